"""A disk."""

from __future__ import annotations

import math
from typing import final

from mypy_extensions import mypyc_attr

Point = tuple[float, float]
SIDES = 48  # of the polygon that stands for a disk


@final
@mypyc_attr(acyclic=True)
class Disk:
    """All points within `radius` of (x, y), m. Immutable."""

    __slots__ = ("radius", "x", "y")

    def __init__(self, x: float, y: float, radius: float) -> None:
        self.x, self.y, self.radius = x, y, radius

    def __repr__(self) -> str:
        return f"Disk({self.x!r}, {self.y!r}, {self.radius!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Disk) and self._numbers == other._numbers

    def __hash__(self) -> int:
        return hash(self._numbers)

    def __reduce__(self) -> tuple[object, ...]:
        return Disk, self._numbers

    @property
    def _numbers(self) -> tuple[float, float, float]:
        return self.x, self.y, self.radius

    @property
    def around(self) -> Disk:
        """The smallest known disk that contains it."""
        return self

    @property
    def area(self) -> float:
        """m^2."""
        return math.pi * self.radius * self.radius

    @property
    def box(self) -> tuple[Point, Point]:
        """The lower left and the upper right corner of the upright rectangle around it, m."""
        return (self.x - self.radius, self.y - self.radius), (self.x + self.radius, self.y + self.radius)

    def distance(self, x: float, y: float) -> float:
        """Distance of (x, y), m; inside, minus the distance to the edge."""
        return math.hypot(self.x - x, self.y - y) - self.radius

    def nearest(self, x: float, y: float) -> Point:
        """The nearest point to (x, y), which is itself inside."""
        dx, dy = x - self.x, y - self.y
        distance = math.hypot(dx, dy)
        if distance <= self.radius:
            return x, y
        scale = self.radius / distance
        return self.x + scale * dx, self.y + scale * dy

    def limit(self, nx: float, ny: float, clearance: float) -> float:
        """The largest c so that n.p >= c + clearance for every p of it, n = (nx, ny) a unit vector, m."""
        return nx * self.x + ny * self.y - (self.radius + clearance)

    def outline(self, sides: int = SIDES) -> list[Point]:
        """Corners of a regular polygon on its edge, counterclockwise, m."""
        angles = [math.tau * side / sides for side in range(sides)]
        return [
            (self.x + self.radius * math.cos(angle), self.y + self.radius * math.sin(angle))
            for angle in angles
        ]
