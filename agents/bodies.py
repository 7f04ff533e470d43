"""Models of a robot's body in the filter: a point, or a body that does not stop at once.

A velocity is commanded only if all motion that may follow is allowed: the sweep of the tick, of the time for
which the base holds the velocity without messages, and of braking (`protocol.bodies.sweep`). If the sweep
satisfies all constraints, so does the rest of it after the tick, and so does braking, which stops earlier on
the same path. So braking is always allowed, and is commanded if no velocity is (docs/safety.md, 2).

A convex program computes a candidate from the position at which the base would stop, as if arcs were
straight. Then the exact sweep is tested; its excess is subtracted from the program's limits, and the program
is solved again. An error in metres exists even without motion, so no path leads away from an edge within the
error: the program keeps a standoff, and if the candidate is not allowed, slower ones are tried, and ones away
from the edges.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, TypeAlias, final

from agents.lines.safe_velocity import Limits, nearest, safe_velocity, wedge
from protocol.bodies.kinematics import Kinematics, Motion
from protocol.bodies.sweep import Sweep, Tolerance, sweep
from protocol.line import HalfPlane
from protocol.messages import STILL, BaseMotion, Vector
from protocol.scenario.model import Scenario

_TRIES: Final = 6  # programs that are solved in a tick
_SHARES: Final = (0.5, 0.2, 0.05)  # of the way from the present velocity to the last candidate
_STEEPEST: Final = 0.99  # share that the program takes an error for at most; the sweep is tested as it is
_FACING: Final = 16  # parts of half a circle, in which directions to leave an edge are tried
_LEAST: Final = 1e-9  # m, by which a limit is lowered at least


def body_of(scenario: Scenario, robot: int) -> BodyModel:
    """The body of one robot of a scenario."""
    body, speed, period = scenario.body_of(robot), scenario.control.speed, scenario.time.step
    longest = 2.0 * scenario.workspace.shape.around.radius  # of any path in the workspace
    if body.ideal:
        return PointBody(speed, period, scenario.actuation.bound, longest)
    base = scenario.base_of(robot) if scenario.is_external else None
    late = None if base is None else base.lateness
    tolerance = Tolerance(body, scenario.actuation.bound, scenario.sensing_of(robot).heading, late)
    return InertialBody(Kinematics(body, period), speed, tolerance, longest)


@final
class PointBody:
    """A point: it follows every velocity at once, and stands at the end of the tick.

    Its attributes are those of `InertialBody`.

    Args:
        noise: bound on the relative execution noise.
        longest: bound of any path, m.
    """

    def __init__(self, speed: float, period: float, noise: float, longest: float) -> None:
        self.reach = min(speed * (1.0 + noise) * period, longest)
        self.standoff = 0.0
        self.swept: Sweep | None = None
        self._speed, self._period, self._noise = speed, period, noise

    def on_motion(self, motion: BaseMotion | None) -> None:
        pass  # it stands

    def velocity(self, desired: Vector, limits: Limits) -> Vector:
        return safe_velocity(desired, limits, speed=self._speed, period=self._period, noise=self._noise)


@final
class InertialBody:
    """A body with inertia.

    Args:
        speed: speed limit of the control point, m/s.
        tolerance: largest deviation of the control point from its nominal path.
        longest: bound of any path, m.
    """

    def __init__(
        self, kinematics: Kinematics, speed: float, tolerance: Tolerance, longest: float = math.inf
    ) -> None:
        self._kinematics, self._tolerance = kinematics, tolerance
        self._speed = min(speed, kinematics.top_speed)
        forth, back = Motion(0.0, self._speed), (-self._speed, 0.0)
        way = kinematics.reach(self._speed) * (1.0 + tolerance.error) + tolerance.slip(forth, back)
        self.reach = min(way, longest)  # the longest path from the beginning of a tick to a stop, m
        # Further sweep of its control point without messages; None if it stands.
        self.swept: Sweep | None = None
        self._motion = Motion(0.0)
        # Distance from any edge at which it can still leave it, in any orientation, m.
        self.standoff = self._least_room()

    def _least_room(self) -> float:
        most = 0.0
        for part in range(_FACING + 1):
            angle = math.pi * part / _FACING
            nx, ny = math.cos(angle), math.sin(angle)
            ax, ay = self._limited((-self._speed * nx, -self._speed * ny))
            rooms = [self._passed((share * ax, share * ay)).extent(nx, ny) for share in (1.0, *_SHARES)]
            most = max(most, min(rooms))
        return most

    def on_motion(self, motion: BaseMotion | None) -> None:
        """Update by the reported motion as a tick begins; None: it stands."""
        if motion is None:
            self._motion = Motion(0.0)
        else:
            self._motion = self._kinematics.motion(
                motion.velocity, motion.heading, motion.stop, motion.before
            )
        if self._motion.stands:
            self.swept = None
        else:
            self.swept = sweep(self._kinematics, self._motion, self._tolerance)

    def velocity(self, desired: Vector, limits: Limits) -> Vector:
        """The velocity to command, m/s, near the desired one, with which the control point satisfies the
        limits whatever messages arrive or are lost.
        """
        x, y = limits.position
        sides = []
        for each in limits.half_planes:
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
            cut = limits.cut(passed)
            if fits and cut is None:
                return command
            if cut is not None:
                cuts.append(cut)
            last = command
        return self._less(last, sides, cuts, limits)

    def _less(
        self, command: Vector, sides: Sequence[HalfPlane], cuts: Sequence[HalfPlane], limits: Limits
    ) -> Vector:
        """A fraction of a command that violates constraints, or a velocity away from them, or to brake."""
        vx, vy = self._motion.velocity
        backoff = self._backoff(command, [*sides, *cuts])
        targets = [(command, share) for share in _SHARES]
        if backoff != STILL:
            targets += [(backoff, share) for share in (1.0, *_SHARES)]
        for (x1, y1), share in targets:
            part = (vx + share * (x1 - vx), vy + share * (y1 - vy))
            passed = self._passed(part)
            if (
                all(passed.extent(side.nx, side.ny) <= side.limit for side in sides)
                and limits.cut(passed) is None
            ):
                return part
        return STILL

    def _backoff(self, command: Vector, sides: Sequence[HalfPlane]) -> Vector:
        """Straight away from the edges that a command violates."""
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
        """The velocity whose stop is nearest to that of the desired one, as if arcs were straight."""
        kinematics, motion, tolerance = self._kinematics, self._motion, self._tolerance
        excess = max(1.0, math.hypot(*desired) / self._speed)
        want = kinematics.lead(motion, (desired[0] / excess, desired[1] / excess))
        vx, vy = motion.velocity
        mx, my = 0.5 * kinematics.period * vx, 0.5 * kinematics.period * vy
        slip = tolerance.slip(motion, (motion.ahead, motion.aside))
        error = tolerance.share(motion, (motion.ahead, motion.aside))
        margin = error * math.hypot(mx, my) + slip
        limits = []
        for index, side in enumerate(sides):
            room = side.limit - side.nx * mx - side.ny * my - margin - self.standoff - taken[index]
            limits.append(HalfPlane(side.nx, side.ny, max(0.0, room)))
        for cut in cuts:
            limits.append(HalfPlane(cut.nx, cut.ny, max(0.0, cut.limit - cut.nx * mx - cut.ny * my - margin)))
        if error > 0.0:
            steepness = min(error, _STEEPEST)
            limits = [half for limit in limits for half in wedge(limit, steepness)]
        ux, uy = kinematics.velocity_for(motion, nearest(want, limits, self.reach))
        excess = max(1.0, math.hypot(ux, uy) / self._speed)
        return ux / excess, uy / excess

    def _limited(self, velocity: Vector) -> Vector:
        """The executable part of a velocity in this tick, m/s."""
        ahead, aside = self._kinematics.limited(self._motion, velocity)
        return Motion(self._motion.heading, ahead, aside).velocity

    def _passed(self, command: Vector) -> Sweep:
        """The sweep of a command without any later message."""
        kinematics, motion = self._kinematics, self._motion
        if command == STILL:
            return sweep(kinematics, kinematics.braking(motion), self._tolerance)
        return sweep(kinematics, motion, self._tolerance, kinematics.limited(motion, command))


BodyModel: TypeAlias = PointBody | InertialBody
