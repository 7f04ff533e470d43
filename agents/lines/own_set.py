"""Where the own centre may be, as half-planes see it."""

from __future__ import annotations

import math
from typing import final

from mypy_extensions import mypyc_attr

from agents.lines.polygon import Polygon
from protocol.bodies.sweep import Sweep
from protocol.line import ROUNDING, SURE, HalfPlane


@final
@mypyc_attr(acyclic=True)
class OwnSet:
    """All places where the own centre may be as a tick begins, and what it still passes. Immutable.

    Args:
        x, y: the own position, m.
        bound: of how far the centre is from there, m; infinite as long as nothing is known.
        shape: the set as seen from there; None: the disk of radius `bound`.
        swept: what the centre passes from there until all commands that are out have ended; None: nothing.

    Attributes: as given.
    """

    __slots__ = ("bound", "shape", "swept", "x", "y")

    def __init__(
        self, x: float, y: float, bound: float, shape: Polygon | None = None, swept: Sweep | None = None
    ) -> None:
        self.x, self.y, self.bound = x, y, bound
        self.shape, self.swept = shape, swept

    def extent(self, nx: float, ny: float) -> float:
        """How far the set reaches from the own position in the direction (nx, ny), m."""
        return self.bound if self.shape is None else self.shape.extent(nx, ny)

    def passed(self, nx: float, ny: float) -> float:
        """How far the set, and all that it passes, reaches in that direction, m."""
        extent = self.extent(nx, ny)
        if self.swept is not None:
            extent += self.swept.extent(nx, ny)
        return extent

    def satisfies(self, side: HalfPlane, growth: float = 0.0) -> bool:
        """Whether the centre is surely in a half-plane, and stays there until every command that is out has
        ended; for a disk that is larger by `growth`, m, than the one that the half-plane is for."""
        return side.slack(self.x, self.y) - growth >= self.passed(side.nx, side.ny) + SURE

    def within(self, x: float, y: float, radius: float) -> bool:
        """Whether the set, and all that it passes, is surely in the disk of that radius around (x, y), m."""
        mx, my, spread = self.x, self.y, self.bound
        if self.swept is not None:
            ax, ay = self.swept.middle
            mx, my, spread = mx + ax, my + ay, spread + self.swept.spread
        return math.hypot(mx - x, my - y) + spread + 2.0 * ROUNDING <= radius

    def kept_in(self, nx: float, ny: float, limit: float) -> HalfPlane:
        """Where the own position must stay so that all of the set stays in that half-plane."""
        return HalfPlane(nx, ny, limit - (self.extent(nx, ny) + 2.0 * ROUNDING))
