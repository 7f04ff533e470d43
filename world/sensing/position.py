"""Where a robot is told that it is: late, noisy, biased, sometimes not at all."""

from __future__ import annotations

from heapq import heappop, heappush

from mypy_extensions import mypyc_attr

from protocol.draws import Purpose
from protocol.messages import Vector
from protocol.scenario.model import Scenario, Sensing
from world.plants.disturbance import Uniforms, truncated_normal


@mypyc_attr(allow_interpreted_subclasses=True)
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
