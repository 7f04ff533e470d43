"""A separating line, and the half-plane that it leaves to the centre of a disk."""

from __future__ import annotations

import math
from typing import NamedTuple

ROUNDING = 1e-9  # m; covers what floating point loses between an agreed line and the judged truth
_UNIT = 1e-12  # how far a normal's length may be from one


class HalfPlane(NamedTuple):
    """Points x with nx x + ny y <= limit (m), (nx, ny) a unit vector."""

    nx: float
    ny: float
    limit: float

    def slack(self, x: float, y: float) -> float:
        """Distance from (x, y) to the edge, m; negative outside."""
        return self.limit - self.nx * x - self.ny * y


class Line(NamedTuple):
    """Unit normal (nx, ny) from the owner to the follower, and offset, m.

    The owner obeys it with n.x + rho <= offset, the follower with n.x - rho >= offset.
    """

    nx: float
    ny: float
    offset: float

    def side(self, radius: float, owner: bool) -> HalfPlane:
        """Where the centre of a disk of `radius` (m) may be when it obeys this line."""
        if owner:
            return HalfPlane(self.nx, self.ny, self.offset - radius)
        return HalfPlane(-self.nx, -self.ny, -self.offset - radius)

    def gap(self, x: float, y: float) -> float:
        """Distance from (x, y) to the line, m; positive on the owner's side."""
        return self.offset - self.nx * x - self.ny * y

    @property
    def is_unit(self) -> bool:
        """Whether the normal has length one; a line from the network must be checked."""
        return abs(math.hypot(self.nx, self.ny) - 1.0) <= _UNIT
