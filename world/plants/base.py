"""A simulated base: it does what its kinematics say, but for an error within its stated bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mypy_extensions import mypyc_attr

from protocol.bodies.base import STEPS, Arc, Base, Motion, chord, turned
from protocol.draws import Purpose
from protocol.messages import Vector
from protocol.scenario.body import Body
from protocol.scenario.model import Scenario
from world.plants.disturbance import Uniforms

_INSIDE = 1.0 - 1e-9  # keeps rounding from carrying an error past its bound


@mypyc_attr(allow_interpreted_subclasses=True)
class SimulatedBase:
    """One robot's base.

    Its error has a direction and a size in each tick, and grows with the way; the lag comes with commands.

    Attributes:
        motion: what it does at the start of the tick to come.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        body: Body = scenario.body_of(robot)
        self.motion = Motion(scenario.spec(robot).heading)
        self._base = Base(body, scenario.time.step)
        self._error = body.error + scenario.actuation.bound
        self._lag, self._play = body.lag, body.play
        self._draws = Uniforms(scenario.seed, Purpose.ACTUATION, robot, 2)

    @property
    def stop(self) -> Vector:
        """From where the control point is to where it stands if the base hears nothing more, m."""
        arc = self._base.halt(self.motion)
        dx, dy = chord(arc, self._base.turn(arc))
        return turned(dx, dy, self.motion.heading)

    def move(self, velocity: Vector | None, tick: int) -> list[Vector]:
        """Go through a tick, with a commanded velocity (m/s) or none; displacement in each part of it, m."""
        base, motion = self._base, self.motion
        part, lag = base.period / STEPS, 0.0
        arcs: list[Arc] = []
        if velocity is not None and (velocity[0] != 0.0 or velocity[1] != 0.0):
            ahead, aside = base.limited(motion, velocity)
            arcs = base.drive(motion, ahead, aside)
            if len(arcs) == 1:
                arcs = [Arc(ahead, aside, part)] * STEPS
            fastest = max(math.hypot(motion.ahead, motion.aside), math.hypot(arcs[0].ahead, arcs[0].aside))
            self.motion, lag = base.driven(motion, ahead, aside), self._lag * fastest + self._play
        else:
            coasting = motion if velocity is None else base.braking(motion)
            for _ in range(STEPS):
                arcs.append(base.coast(coasting, part))
                coasting = base.coasted(coasting, part)
            self.motion = coasting
        return self._disturbed(motion.heading, arcs, lag, tick)

    def _disturbed(self, heading: float, arcs: Sequence[Arc], lag: float, tick: int) -> list[Vector]:
        """Displacements along arcs, m, each with its share of the tick's error."""
        ways = [math.hypot(arc.ahead, arc.aside) * arc.duration for arc in arcs]
        way = math.fsum(ways)
        ex = ey = 0.0
        if way > 0.0 and (self._error > 0.0 or lag > 0.0):
            size, direction = self._draws.at(tick)
            share = math.sqrt(size) * _INSIDE * (self._error + lag / way)
            ex = share * math.cos(2.0 * math.pi * direction)
            ey = share * math.sin(2.0 * math.pi * direction)
        steps = []
        for arc, passed in zip(arcs, ways, strict=True):
            turn = self._base.turn(arc)
            cx, cy = chord(arc, turn)
            dx, dy = turned(cx, cy, heading)
            steps.append((dx + ex * passed, dy + ey * passed))
            heading += turn
        return steps
