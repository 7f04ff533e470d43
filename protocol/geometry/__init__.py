"""Closed convex sets of the plane: what stands in a workspace, and what encloses it. Lengths in m."""

from protocol.geometry.disk import Disk
from protocol.geometry.polygon import ConvexPolygon

Shape = Disk | ConvexPolygon

__all__ = ["ConvexPolygon", "Disk", "Shape"]
