"""A line that touches something that stands, and faces a robot: no line has to be agreed with what no process
moves."""

from __future__ import annotations

import math

from protocol.geometry import Shape
from protocol.line import Line
from protocol.messages import Vector


def tangent(shape: Shape, x: float, y: float, low: bool, near: float) -> Line | None:
    """The line between (x, y), m, and what stands; None if (x, y) is in it.

    Of what is more than `near` (m) away, the disk around it counts.

    Args:
        low: whether the robot is the low end of the binding.
    """
    around = shape.around
    dx, dy = around.x - x, around.y - y
    distance = math.hypot(dx, dy)
    target: Shape = around
    if shape is not around and distance - around.radius <= near:
        target = shape
        px, py = shape.nearest(x, y)
        dx, dy = px - x, py - y
        distance = math.hypot(dx, dy)
    if distance == 0.0:
        return None
    nx, ny = dx / distance, dy / distance
    edge = target.limit(nx, ny, 0.0)
    return Line(nx, ny, edge) if low else Line(-nx, -ny, -edge)


def deficit(shape: Shape, x: float, y: float, room: float) -> Vector:
    """How far to back off from (x, y), m, to be `room` (m) from what stands."""
    px, py = shape.nearest(x, y)
    if px == x and py == y:
        px, py = shape.around.x, shape.around.y
    dx, dy = x - px, y - py
    distance = math.hypot(dx, dy)
    lacking = room - shape.distance(x, y)
    if lacking <= 0.0:
        return 0.0, 0.0
    if distance == 0.0:
        return lacking, 0.0
    return lacking * dx / distance, lacking * dy / distance
