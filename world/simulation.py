"""Simulated robots: their plant; position sensors, whose measurements may be late, noisy, biased or missing;
and odometry, which gives displacement and heading."""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from heapq import heappop, heappush
from types import MappingProxyType

from protocol.bodies.kinematics import turned
from protocol.draws import Purpose, Uniforms
from protocol.messages import STILL, BaseMotion, Command, Sense, Vector
from protocol.scenario.body import span_of
from protocol.scenario.model import Scenario
from world.plants.plant import BaseReport, PastDisks, plant_of, truncated_normal


class Sensor:
    """One robot's position sensor.

    With random delays a later measurement may overtake an earlier one, which then is never delivered.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.delayed = 0  # late measurements
        self.missing = 0  # ticks without a measurement
        self.dropped = 0  # measurements lost by dropout
        sensing = self._sensing = scenario.sensing_of(robot)
        self.bound = sensing.bound  # largest error of a measurement, m
        self.ideal = span_of(sensing.delay) == (0.0, 0.0) and sensing.bound == sensing.dropout == 0.0
        self._scenario = scenario
        self._draws = Uniforms(scenario.seed, Purpose.SENSING, robot, 4)
        self._arriving: list[tuple[int, int, Vector]] = []
        self._newest = -1

    def measure(self, tick: int, truth: Vector) -> tuple[Vector | None, int]:
        """Measured position, and the tick of the measurement; (None, tick) if no new one arrived.

        Called once for every tick, in order, with the true position at its start.
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
        """Take one measurement and schedule its arrival."""
        sensing = self._sensing
        dropout, delay, radial, angular = self._draws.at(tick)
        if dropout < sensing.dropout:
            self.dropped += 1
            return
        low, high = span_of(sensing.delay)
        arrival = tick + self._scenario.ticks(low + delay * (high - low))
        nx, ny = truncated_normal(radial, angular, sensing.noise, sensing.largest_noise)
        measured = (truth[0] + sensing.bias[0] + nx, truth[1] + sensing.bias[1] + ny)
        heappush(self._arriving, (arrival, tick, measured))


_INSIDE = 1.0 - 1e-9  # keeps errors within their bound in spite of rounding


class OdometrySensor:
    """Odometry of one robot's base, with errors up to those of the scenario.

    A base steers by its estimate of its heading, so its reports, and the Commands to it, are in a frame that
    is rotated by the same error within a tick.

    Args:
        slips: whether the plant's report is inexact itself; then no error is added to the displacement.
    """

    def __init__(self, scenario: Scenario, robot: int, slips: bool) -> None:
        body = scenario.body_of(robot)
        self._share, self._drift = body.odometry, body.drift
        # A point has no frame of its own, as its filter assumes, whatever its odometry is.
        self._heading = 0.0 if body.ideal else scenario.sensing_of(robot).heading
        self._slips = slips
        self.ideal = body.ideal and self._share == self._drift == 0.0
        self._draws = Uniforms(scenario.seed, Purpose.ODOMETRY, robot, 3)

    def read(self, report: BaseReport, tick: int) -> tuple[Vector, float, BaseMotion | None]:
        """Displacement in the last tick, its error bound (m), and the motion that the base reports."""
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
        """The base's execution of a commanded velocity, which it takes to be in its own frame."""
        return turned(velocity[0], velocity[1], -self._askew(tick))

    def _askew(self, tick: int) -> float:
        """The error of its direction, rad."""
        return self._heading * (2.0 * self._draws.at(tick)[2] - 1.0) if self._heading > 0.0 else 0.0


class SimulatedFleet:
    """True positions of all disks, and the robots' measurements of them.

    Args:
        past: the disks at the end of an earlier world, if there was one; they are static there.
    """

    def __init__(self, scenario: Scenario, past: PastDisks | None = None) -> None:
        scenario = scenario if past is None else past.moved(scenario)
        # As of `External`; the places are the truth here.
        self.bounds: Mapping[int, float] = MappingProxyType({})
        self.founding_bounds = self.bounds
        self.unsettled: Set[int] = frozenset()
        self.largest_bound: float | None = None
        self.plant = plant_of(scenario, 1 if past is None else past.parts)
        self.sensors = {robot: Sensor(scenario, robot) for robot in scenario.ids}  # of position
        self._odometers = {robot: OdometrySensor(scenario, robot, self.plant.slips) for robot in scenario.ids}
        # Path lengths in earlier worlds, and of removed robots, m.
        self._before = {} if past is None else past.ways
        self._turn = any(not scenario.body_of(robot).ideal for robot in scenario.ids)

    @property
    def places(self) -> dict[int, Vector]:
        """Position of every disk's centre, m, by robot id."""
        return dict(zip(self.plant.ids, self.plant.positions, strict=True))

    @property
    def lengths(self) -> dict[int, float]:
        """Path length of every present or past robot, m; of all robots with the same id together."""
        lengths = dict(self._before)
        for robot, length in zip(self.plant.ids, self.plant.lengths, strict=True):
            lengths[robot] = lengths.get(robot, 0.0) + length
        return lengths

    @property
    def past(self) -> PastDisks:
        """The disks for a successor."""
        turn = enumerate(self.plant.ids) if self._turn else ()
        headings = {robot: self.plant.report(index).heading for index, robot in turn}
        return PastDisks(self.places, headings, self.lengths, parts=self.plant.parts)

    def sense(self, tick: int) -> dict[int, Sense]:
        """Measurements of every robot at the start of `tick`; the sensors of absent ones continue."""
        sensed, plant = {}, self.plant
        for index, (robot, place) in enumerate(zip(plant.ids, plant.positions, strict=True)):
            sensor = self.sensors[robot]
            position, stamp = sensor.measure(tick, place)
            moved, bound, motion = self._odometers[robot].read(plant.report(index), tick)
            # An integer takes one byte of nine.
            sensed[robot] = Sense(position, stamp, sensor.bound or 0, moved, bound or 0, motion)
        return sensed

    @property
    def measurements(self) -> dict[str, int]:
        """Numbers of late, missing and dropped measurements."""
        kinds = ("delayed", "missing", "dropped")
        return {kind: sum(getattr(each, kind) for each in self.sensors.values()) for kind in kinds}

    def on_command(self, command: Command) -> None:
        """Do nothing: simulated robots report no position."""

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """Advance a tick with commanded velocities (m/s) by robot id; others receive none."""
        obeyed = {robot: self._odometers[robot].obeyed(commands[robot], tick) for robot in commands}
        self.plant.move(obeyed, tick)

    def brake(self, tick: int) -> None:
        """Advance a tick in which every base is ordered to stand."""
        self.plant.move(dict.fromkeys(self.plant.ids, STILL), tick)

    def resting(self) -> dict[int, Vector]:
        """Positions of robots that stand until they receive another command, m, by robot id."""
        plant = self.plant
        return {
            robot: position
            for index, (robot, position) in enumerate(zip(plant.ids, plant.positions, strict=True))
            if plant.stands(index)
        }

    def stop(self, tick: int) -> None:
        """Do nothing: during an emergency stop `brake` is called."""

    def moving(self) -> frozenset[int]:
        """Robots that do not stand."""
        return frozenset(self.plant.ids).difference(self.resting())

    def set_fleet(self, scenario: Scenario) -> None:
        """Set the robots; a new one is at its start."""
        plant = self.plant
        for robot, length in zip(plant.ids, plant.lengths, strict=True):
            if robot not in scenario.ids:
                self._before[robot] = self._before.get(robot, 0.0) + length
        plant.set_fleet(scenario)
        self.sensors = {robot: self.sensors.get(robot) or Sensor(scenario, robot) for robot in scenario.ids}
        self._odometers = {
            robot: self._odometers.get(robot) or OdometrySensor(scenario, robot, plant.slips)
            for robot in scenario.ids
        }
