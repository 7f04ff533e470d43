"""A body that does not stop at once: a velocity is commanded only if all that follows from it is allowed.

What follows is the sweep of the tick, of the time that the base holds the velocity if it hears nothing, and
of braking. If it lies in everything that must be obeyed, then so does what is left of it after the tick, and
braking, which leads along the same way, ends sooner. So braking is always allowed, and is what remains if no
velocity is (docs/safety.md, step 2).

The candidate comes from a convex program in the place where the base would stand, as if its arcs were
straight. The sweep is tested as it is; what it lacks is taken off the program's limits, and the program
solved again. Too near an edge nothing leads on, because lag and play are there before any way is made: so the
program keeps a berth, and where no velocity is left, the body first makes room.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from agents.lines.boundary import Boundary
from agents.lines.line import HalfPlane
from agents.lines.polygon import Polygon
from agents.lines.safe_velocity import nearest, wedge
from protocol.bodies.base import Base, Motion
from protocol.bodies.sweep import Miss, Sweep, sweep
from protocol.messages import BaseMotion, Vector

_TRIES: Final = 6  # programs that are solved in a tick
_SHARES: Final = (0.5, 0.2)  # of the way from the present velocity to the last candidate, tried at last
_STEEPEST: Final = 0.99  # share that the program takes an error for at most; the sweep is tested as it is
_FACING: Final = 16  # parts of half a circle, in which directions to leave an edge are tried
_LEAST: Final = 1e-9  # m, by which a limit is lowered at least
_TINY: Final = 1e-100  # m; what can be divided by

STILL: Vector = (0.0, 0.0)  # to a base: brake


@final
class InertialBody:
    """See `agents.bodies.body.Body`.

    Args:
        base: the body's kinematics.
        speed: speed limit of the control point, m/s.
        miss: by how much the control point may miss where it is sent, if it faces as it says.
        heading: rad, by which the direction that it says it has may be off.
    """

    def __init__(self, base: Base, speed: float, miss: Miss, heading: float = 0.0) -> None:
        turned_by = 2.0 * math.sin(0.5 * heading)  # of all that it does
        miss = self._miss = Miss(miss.error + turned_by, miss.lag, miss.play)
        self.reach = base.reach(speed) * (1.0 + miss.error) + miss.lag * speed + miss.play
        self.swept: Sweep | None = None
        self._base, self._speed = base, speed
        self._motion = Motion(0.0)
        self.berth = self._least_room()

    def _least_room(self) -> float:
        """How far it can stand off an edge and still leave it straight on, whichever way it faces, m."""
        most = 0.0
        for part in range(_FACING + 1):
            angle = math.pi * part / _FACING
            nx, ny = math.cos(angle), math.sin(angle)
            ax, ay = self._limited((-self._speed * nx, -self._speed * ny))
            room = self._passed((ax, ay)).extent(nx, ny)
            for share in _SHARES:
                room = min(room, self._passed((share * ax, share * ay)).extent(nx, ny))
            most = max(most, room)
        return most

    def on_motion(self, motion: BaseMotion | None) -> None:
        """See `agents.bodies.body.Body`."""
        if motion is None:
            self._motion = Motion(0.0)
        else:
            self._motion = self._base.motion(motion.velocity, motion.heading, motion.stop)
        if self._motion.stands:
            self.swept = None
            return
        arcs = [self._base.halt(self._motion)]
        self.swept = sweep(self._base, self._motion, arcs, miss=self._miss, rise=0)

    def velocity(
        self,
        desired: Vector,
        position: Vector,
        half_planes: Sequence[HalfPlane],
        boundary: Boundary,
        shape: Polygon | None,
    ) -> Vector:
        """See `agents.bodies.body.Body`."""
        x, y = position
        sides = []
        for each in half_planes:
            slack = each.slack(x, y)
            if slack < self.reach:
                sides.append(HalfPlane(each.nx, each.ny, slack if slack > 0.0 else 0.0))
        taken = [0.0] * len(sides)
        cuts: list[HalfPlane] = []
        last = self._motion.velocity
        for _ in range(_TRIES):
            command = self._limited(self._candidate(desired, sides, taken, cuts))
            if command == STILL:
                return STILL
            passed = self._passed(command)
            fits = True
            for index, side in enumerate(sides):
                excess = passed.extent(side.nx, side.ny) - side.limit
                if excess > 0.0:
                    fits = False
                    taken[index] += excess + _LEAST
            cut = _cut(boundary, x, y, shape, passed)
            if fits and cut is None:
                return command
            if cut is not None:
                cuts.append(cut)
            last = command
        return self._less(last, sides, boundary, x, y, shape)

    def _less(
        self,
        command: Vector,
        sides: Sequence[HalfPlane],
        boundary: Boundary,
        x: float,
        y: float,
        shape: Polygon | None,
    ) -> Vector:
        """A part of a command that is too much, or away from where it leads; at last, to brake."""
        vx, vy = self._motion.velocity
        away = self._away(command, sides)
        targets = [(command, share) for share in _SHARES]
        if away != STILL:
            targets += [(away, share) for share in (1.0, *_SHARES)]
        for (x1, y1), share in targets:
            part = (vx + share * (x1 - vx), vy + share * (y1 - vy))
            passed = self._passed(part)
            if (
                all(passed.extent(side.nx, side.ny) <= side.limit for side in sides)
                and _cut(boundary, x, y, shape, passed) is None
            ):
                return part
        return STILL

    def _away(self, command: Vector, sides: Sequence[HalfPlane]) -> Vector:
        """Straight away from the edges that a command comes too near to."""
        passed = self._passed(command)
        nx = ny = 0.0
        for side in sides:
            if passed.extent(side.nx, side.ny) > side.limit:
                nx, ny = nx + side.nx, ny + side.ny
        length = math.hypot(nx, ny)
        if length < _LEAST:
            return STILL
        return self._limited((-self._speed * nx / length, -self._speed * ny / length))

    def _candidate(
        self, desired: Vector, sides: Sequence[HalfPlane], taken: Sequence[float], cuts: Sequence[HalfPlane]
    ) -> Vector:
        """The velocity whose place to stand is nearest to the desired one's, as if all ways were straight."""
        base, motion, miss = self._base, self._motion, self._miss
        excess = max(1.0, math.hypot(*desired) / self._speed)
        want = base.lead(motion, (desired[0] / excess, desired[1] / excess))
        vx, vy = motion.velocity
        mx, my = 0.5 * base.period * vx, 0.5 * base.period * vy
        margin = miss.error * math.hypot(mx, my) + miss.lag * math.hypot(vx, vy) + miss.play
        limits = []
        for index, side in enumerate(sides):
            room = side.limit - side.nx * mx - side.ny * my - margin - self.berth - taken[index]
            limits.append(HalfPlane(side.nx, side.ny, max(0.0, room)))
        for cut in cuts:
            limits.append(HalfPlane(cut.nx, cut.ny, max(0.0, cut.limit - cut.nx * mx - cut.ny * my - margin)))
        if miss.error > 0.0:
            limits = [half for limit in limits for half in wedge(limit, min(miss.error, _STEEPEST))]
        ux, uy = base.velocity_for(motion, nearest(want, limits, self.reach))
        excess = max(1.0, math.hypot(ux, uy) / self._speed)
        return ux / excess, uy / excess

    def _limited(self, velocity: Vector) -> Vector:
        """What the base can make of a velocity in this tick, m/s."""
        ahead, aside = self._base.limited(self._motion, velocity)
        return Motion(self._motion.heading, ahead, aside).velocity

    def _passed(self, command: Vector) -> Sweep:
        """Everything that follows from a command if nothing more is heard."""
        base, motion = self._base, self._motion
        if command == STILL:
            arcs = [base.halt(base.braking(motion))]
            return sweep(base, motion, arcs, miss=self._miss, rise=0)
        ahead, aside = base.limited(motion, command)
        arcs = base.drive(motion, ahead, aside)
        rise = len(arcs)
        arcs.append(base.halt(base.driven(motion, ahead, aside)))
        return sweep(base, motion, arcs, miss=self._miss, rise=rise)


def _cut(boundary: Boundary, x: float, y: float, shape: Polygon | None, passed: Sweep) -> HalfPlane | None:
    """A half-plane of displacements that the sweep of a place known as `shape` around (x, y) violates."""
    found: HalfPlane | None = None
    for index, margin in enumerate(passed.margins):
        dx, dy = passed.xs[index], passed.ys[index]
        if dx == dy == 0.0 and margin > 0.0:
            dx = _TINY  # it comes back to where it began, but for the margin
        way = math.hypot(dx, dy)
        if way > 0.0:
            cut = boundary.cut(x, y, shape, dx, dy, noise=margin / way)
            found = cut if cut is not None else found
    return found
