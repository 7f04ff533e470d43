"""What a robot is told of itself: its position, late, noisy, biased, sometimes not at all; and by odometry
how far it went, and which way it faces."""

from __future__ import annotations

import math
from heapq import heappop, heappush

from protocol.bodies.kinematics import turned
from protocol.draws import Purpose
from protocol.messages import BaseMotion, Vector
from protocol.scenario.model import Scenario, Sensing
from world.plants.disturbance import Uniforms, truncated_normal
from world.plants.plant import Report


class Sensor:
    """One robot's position sensor.

    A measurement of tick s arrives at tick s + d, the delay d drawn anew for each; with random
    delays a later one may overtake an earlier one, which then is never delivered.

    Attributes:
        bound: largest error of a measurement, m.
        delayed: measurements delivered at a later tick than they were taken.
        missing: ticks without a measurement.
        dropped: measurements that dropout swallowed.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.delayed = 0
        self.missing = 0
        self.dropped = 0
        self._sensing = scenario.sensing_of(robot)
        self.bound = self._sensing.bound
        self.ideal = _is_ideal(self._sensing)
        self._noise_bound = _noise_bound(self._sensing)
        self._scenario = scenario
        self._draws = Uniforms(scenario.seed, Purpose.SENSING, robot, 4)
        self._arriving: list[tuple[int, int, Vector]] = []
        self._newest = -1

    def measure(self, tick: int, truth: Vector) -> tuple[Vector | None, int]:
        """Position as measured and the tick at which it was taken; (None, tick) when nothing new arrived.

        To be called once for every tick, in order, with the true position at its start.
        """
        if self.ideal:
            return truth, tick
        self._take(tick, truth)
        position, stamp = None, tick
        while self._arriving and self._arriving[0][0] <= tick:
            _, taken, measured = heappop(self._arriving)
            if taken > self._newest:
                self._newest, position, stamp = taken, measured, taken
        if position is None:
            self.missing += 1
        elif stamp < tick:
            self.delayed += 1
        return position, stamp

    def _take(self, tick: int, truth: Vector) -> None:
        """Take one measurement and send it on its way."""
        sensing = self._sensing
        dropout, delay, radial, angular = self._draws.at(tick)
        if dropout < sensing.dropout:
            self.dropped += 1
            return
        low, high = sensing.delay if isinstance(sensing.delay, tuple) else (sensing.delay, sensing.delay)
        arrival = tick + self._scenario.ticks(low + delay * (high - low))
        nx, ny = truncated_normal(radial, angular, sensing.noise, self._noise_bound)
        measured = (truth[0] + sensing.bias[0] + nx, truth[1] + sensing.bias[1] + ny)
        heappush(self._arriving, (arrival, tick, measured))


def _is_ideal(sensing: Sensing) -> bool:
    return sensing.delay in (0.0, (0.0, 0.0)) and sensing.bound == 0.0 and sensing.dropout == 0.0


def _noise_bound(sensing: Sensing) -> float:
    """Largest length of the noise alone, m."""
    return 3.0 * sensing.noise if sensing.noise_bound is None else sensing.noise_bound


_INSIDE = 1.0 - 1e-9  # keeps rounding from carrying an error past its bound


class Odometer:
    """What one robot's base reports, with errors up to those that the scenario states.

    A base steers by the direction that it believes it has, so whatever it says, and all that it is told, is
    in a frame that is turned by the same error in a tick.

    Args:
        slips: whether what the plant reports is not exact already; then no error is added to the way.
    """

    def __init__(self, scenario: Scenario, robot: int, slips: bool) -> None:
        body = scenario.body_of(robot)
        self._share, self._drift = body.odometry, body.drift
        self._heading = scenario.sensing_of(robot).heading
        self._slips = slips
        self._has_heading = not body.ideal and self._heading > 0.0
        self.ideal = body.ideal and self._share == self._drift == 0.0
        self._draws = Uniforms(scenario.seed, Purpose.ODOMETRY, robot, 3)

    def read(self, report: Report, tick: int) -> tuple[Vector, float, BaseMotion | None]:
        """Displacement in the tick before, its error bound (m), and what the base says that it does."""
        displacement = report.displacement
        if self.ideal:
            return displacement, 0.0, None
        dx, dy = displacement
        if not self._slips:
            size, direction, _ = self._draws.at(tick)
            off = math.sqrt(size) * _INSIDE * (self._share * report.way + self._drift)
            dx += off * math.cos(2.0 * math.pi * direction)
            dy += off * math.sin(2.0 * math.pi * direction)
        bound = (self._share * report.way + self._drift) / (1.0 - self._share)
        if report.stop is None:
            return (dx, dy), bound, None
        askew = self._askew(tick)
        velocity = turned(report.velocity[0], report.velocity[1], askew)
        stop = turned(report.stop[0], report.stop[1], askew)
        return (dx, dy), bound, BaseMotion(velocity, report.heading + askew, stop)

    def obeyed(self, velocity: Vector, tick: int) -> Vector:
        """What the base makes of a commanded velocity, which it takes to be in its own frame; a point has no
        such frame, and its filter counts on that, whatever its odometry is."""
        if not self._has_heading:
            return velocity
        return turned(velocity[0], velocity[1], -self._askew(tick))

    def _askew(self, tick: int) -> float:
        """The error of its direction, rad."""
        return self._heading * (2.0 * self._draws.at(tick)[2] - 1.0) if self._heading > 0.0 else 0.0
