"""Everything that stands in the workspace and is no robot, as one robot keeps clear of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

from agents.lines.line import ROUNDING, HalfPlane
from agents.lines.own_set import OwnSet
from agents.lines.polygon import Polygon
from agents.lines.tangent import Tangent
from protocol.bodies.sweep import Sweep
from protocol.geometry import Shape
from protocol.messages import Thing, Vector

_ROOM: Final = 0.25  # of the own radius, by which to be clear of what is to appear
_FAR: Final = 4.0  # ticks of motion: what is farther away is kept to as the disk around it


class Things:
    """The tangents to all things.

    Args:
        radius: of this robot, m.
        shapes: what stands from the start, by number.
        start: where this robot began the run, m, clear of all of them; None if it did not.
        speed: the most that the robot really moves, m/s.
        period: of one tick, s.
        reach: see `agents.lines.separating_lines.SeparatingLines`.

    Attributes:
        held: the thing that only a smaller disk may be clear of, as this robot asks to take it up; 0 for
            none.
    """

    def __init__(
        self,
        radius: float,
        shapes: Mapping[int, Shape],
        start: Vector | None,
        *,
        speed: float,
        period: float,
        reach: float = 0.0,
    ) -> None:
        self.held = 0
        self._radius, self._period, self._max_step = radius, period, speed * period
        self._reach = reach if reach > 0.0 else self._max_step
        self._tangents = {number: Tangent(shape, radius) for number, shape in shapes.items()}
        self._listed = set(shapes)
        self._each = list(self._tangents.values())
        self._appearing: set[int] = set()
        self._own = OwnSet(0.0, 0.0, math.inf)
        if start is not None:
            for tangent in self._each:
                tangent.renew(OwnSet(*start, 0.0), math.inf)

    def locate(
        self, position: Vector, bound: float, shape: Polygon | None = None, swept: Sweep | None = None
    ) -> None:
        """Take the own position (m) at the start of a tick; the truth is at most `bound` (m) from it, and
        within `shape` around it if that is given. From there it passes `swept` until all commands that are
        still out have ended."""
        self._own = OwnSet(*position, bound, shape, swept)
        for tangent in self._each:
            tangent.renew(self._own, _FAR * self._max_step)

    @property
    def shapes(self) -> list[Shape]:
        """All of them."""
        return [tangent.shape for tangent in self._each]

    @property
    def ready(self) -> bool:
        """Whether this robot is behind a tangent to everything; who is not must stand still."""
        return all(
            tangent.half_plane is not None
            for number, tangent in self._tangents.items()
            if number not in self._appearing
        )

    @property
    def keeps_clear(self) -> bool:
        """Whether the own disk is and stays clear of everything that is to appear."""
        return not self._appearing or all(
            self._tangents[number].half_plane is not None for number in self._appearing
        )

    def follow(self, changes: Sequence[Thing]) -> None:
        """A newer roster says which things came, are to come, or went; the others of the scenario stand."""
        news = {each.number: each for each in changes}
        for number in list(self._tangents):
            gone = news[number].status == "gone" if number in news else number not in self._listed
            if gone:
                del self._tangents[number]
        for number, each in news.items():
            if each.status != "gone" and number not in self._tangents:
                tangent = self._tangents[number] = Tangent(each.shape, self._radius)
                tangent.renew(self._own)
        self._appearing = {number for number, each in news.items() if each.status == "appearing"}
        self._each = list(self._tangents.values())

    def has_room(self, radius: float, held: int = 0) -> bool:
        """Whether the own disk would be clear of everything if it were one of `radius`, m, thing `held` left
        out."""
        for number, tangent in self._tangents.items():
            side, growth = tangent.half_plane, radius - tangent.radius
            if number == held or (side is None and number in self._appearing):
                continue
            if side is None or not self._own.satisfies(side, growth):
                return False
        return True

    def resize(self, radius: float, held: int = 0) -> None:
        """The own disk is one of `radius` from now on, m; thing `held` is kept clear of as before."""
        self._radius, self.held = radius, held
        for number, tangent in self._tangents.items():
            if number != held:
                tangent.resize(radius)

    def make_room(self, desired: Vector) -> Vector:
        """The desired velocity (m/s), turned away from where something is to appear and this robot is."""
        own, (vx, vy) = self._own, desired
        for number in sorted(self._appearing):
            tangent = self._tangents[number]
            if tangent.half_plane is not None:
                continue
            dx, dy = tangent.lacking(own.x, own.y, own.bound + _ROOM * self._radius)
            lacking = math.hypot(dx, dy)
            if lacking > 0.0:
                nx, ny = dx / lacking, dy / lacking
                more = max(0.0, lacking / self._period - nx * vx - ny * vy)
                vx, vy = vx + more * nx, vy + more * ny
        return vx, vy

    def half_planes(self) -> list[HalfPlane]:
        """Where the estimated own centre must stay, without those out of reach within a tick; radius and
        extent of the own set are subtracted."""
        own = self._own
        near = own.bound + 2.0 * ROUNDING + 2.0 * self._reach
        found = []
        for tangent in self._each:
            side = tangent.half_plane
            if side is not None and side.slack(own.x, own.y) < near:
                found.append(own.kept_in(side.nx, side.ny, side.limit))
        return found

    def crossed(self, x: float, y: float, shape: Polygon) -> list[tuple[int, HalfPlane]]:
        """Tangents, by thing, that a set around (x, y) sticks out of. The truth does not."""
        radius = shape.radius
        found = []
        for number, tangent in self._tangents.items():
            side = tangent.half_plane
            if side is None or side.slack(x, y) >= radius:
                continue
            if side.slack(x, y) < shape.extent(side.nx, side.ny):
                found.append((number, side))
        return found
