"""A separating line, and the half-plane that it leaves to the centre of a disk."""

from __future__ import annotations

import math
from typing import Final, final

from mypy_extensions import mypyc_attr

ROUNDING: Final = 1e-9  # m; covers rounding between an agreed line and the judged truth
SURE: Final = 0.25 * ROUNDING  # m, margin with which a half-plane must be satisfied at its agreement
_ULP: Final = 2.0**-51  # of |x| + |y|: more than the rounding of two coordinates, and of an edge's distance
UNIT: Final = 1.0 + 1e-12  # greatest length of a unit vector, with rounding


def is_unit(nx: float, ny: float) -> bool:
    """Whether a vector has length one, up to rounding."""
    return abs(math.hypot(nx, ny) - 1.0) <= UNIT - 1.0


def room_of(slack: float, x: float, y: float) -> float:
    """Allowed displacement from an exact (x, y) towards an edge at distance `slack`, of which twice ROUNDING
    was subtracted before; all in m.

    Zero if there is none. Once half of the subtracted distance is used, it must lead away by the rounding
    error of its addition to a position, since a robot that slides along an edge has that error in every tick.
    """
    if slack > 0.0:
        return slack
    return 0.0 if slack >= -ROUNDING else -_ULP * (abs(x) + abs(y))


@final
@mypyc_attr(acyclic=True)
class HalfPlane:
    """Points x with nx x + ny y <= limit (m), (nx, ny) a unit vector. Immutable."""

    __slots__ = ("limit", "nx", "ny")

    def __init__(self, nx: float, ny: float, limit: float) -> None:
        self.nx, self.ny, self.limit = nx, ny, limit

    def __repr__(self) -> str:
        return f"HalfPlane({self.nx!r}, {self.ny!r}, {self.limit!r})"

    def slack(self, x: float, y: float) -> float:
        """Distance from (x, y) to the edge, m; negative outside."""
        return self.limit - self.nx * x - self.ny * y


@final
@mypyc_attr(acyclic=True)
class Line:
    """Unit normal (nx, ny) from the owner to the follower, and offset, m. Immutable.

    The owner obeys it with n.x + rho <= offset, the follower with n.x - rho >= offset.
    """

    __slots__ = ("nx", "ny", "offset")

    def __init__(self, nx: float, ny: float, offset: float) -> None:
        self.nx, self.ny, self.offset = nx, ny, offset

    def __repr__(self) -> str:
        return f"Line({self.nx!r}, {self.ny!r}, {self.offset!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Line) and self._numbers == other._numbers

    def __hash__(self) -> int:
        return hash(self._numbers)

    @property
    def _numbers(self) -> tuple[float, float, float]:
        return self.nx, self.ny, self.offset

    def side(self, radius: float, owner: bool) -> HalfPlane:
        """Half-plane of the centre of a disk of `radius` (m) that obeys this line."""
        if owner:
            return HalfPlane(self.nx, self.ny, self.offset - radius)
        return HalfPlane(-self.nx, -self.ny, -self.offset - radius)

    def gap(self, x: float, y: float) -> float:
        """Distance from (x, y) to the line, m; positive on the owner's side."""
        return self.offset - self.nx * x - self.ny * y

    @property
    def is_unit(self) -> bool:
        """Whether the normal has length one; a line from the network must be checked."""
        return is_unit(self.nx, self.ny)
