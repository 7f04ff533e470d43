"""Robots that are simulated: the plant that carries them, and the sensors and bases that tell them of it."""

from __future__ import annotations

from collections.abc import Mapping, Set
from types import MappingProxyType

from protocol.messages import Command, Sense, Vector
from protocol.scenario.model import Scenario
from world.plants.integrator import STANDING
from world.plants.plant import PastDisks, plant_of
from world.sensing import Odometer, Sensor


class Simulation:
    """Every robot's disk, where it really is, and what the robot is told of that.

    Args:
        past: where an earlier world has left the disks, if there was one; they stand there.

    Attributes:
        plant: what moves the disks.
        sensors: of position, by robot id.
        bounds: by how much `places` are off, m, by robot id: not at all.
        founding_bounds: the same as a run begins.
        largest_bound: None, for the places are the truth.
    """

    def __init__(self, scenario: Scenario, past: PastDisks | None = None) -> None:
        scenario = scenario if past is None else past.moved(scenario)
        self.bounds: Mapping[int, float] = MappingProxyType({})
        self.founding_bounds = self.bounds
        self.unsettled: Set[int] = frozenset()
        self.largest_bound: float | None = None
        self.plant = plant_of(scenario)
        self.sensors = {robot: Sensor(scenario, robot) for robot in scenario.ids}
        self._odometers = {robot: Odometer(scenario, robot, self.plant.slips) for robot in scenario.ids}
        # Path lengths in earlier worlds, and of robots that left, m.
        self._before = {} if past is None else past.ways
        self._turn = any(not scenario.body_of(robot).ideal for robot in scenario.ids)

    @property
    def places(self) -> dict[int, Vector]:
        """Where every disk's centre is, m, by robot id."""
        return dict(zip(self.plant.ids, self.plant.positions, strict=True))

    def place(self, robot: int) -> Vector:
        """Where one disk's centre is, m."""
        return self.plant.positions[self.plant.ids.index(robot)]

    @property
    def lengths(self) -> dict[int, float]:
        """Path length of every robot that is or was there, m; of all that had the same id together."""
        return self.past.ways

    @property
    def past(self) -> PastDisks:
        """What another world needs to go on from here."""
        plant = self.plant
        headings = [plant.report(index).heading for index in range(len(plant.ids))] if self._turn else []
        return PastDisks(plant.ids, plant.positions, headings, plant.lengths, self._before)

    def sense(self, tick: int) -> dict[int, Sense]:
        """What every robot is told of itself at the start of `tick`, those that do not listen included:
        sensors keep running."""
        sensed, plant = {}, self.plant
        for index, (robot, place) in enumerate(zip(plant.ids, plant.positions, strict=True)):
            sensor = self.sensors[robot]
            position, stamp = sensor.measure(tick, place)
            moved, bound, motion = self._odometers[robot].read(plant.report(index), tick)
            # An integer takes one byte of nine.
            sensed[robot] = Sense(position, stamp, sensor.bound or 0, moved, bound or 0, motion)
        return sensed

    def hear(self, command: Command) -> None:
        """Robots that are simulated have nothing to report."""

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """Go through a tick with commanded velocities (m/s) by robot id; others hear nothing."""
        obeyed = {robot: self._odometers[robot].obeyed(commands[robot], tick) for robot in commands}
        self.plant.move(obeyed, tick)

    def brake(self, tick: int) -> None:
        """Go through a tick in which every base is told to stand."""
        self.plant.move(dict.fromkeys(self.plant.ids, STANDING), tick)

    def resting(self) -> dict[int, Vector]:
        """Where robots are that do not move until they hear another command, m, by robot id."""
        plant = self.plant
        return {
            robot: position
            for index, (robot, position) in enumerate(zip(plant.ids, plant.positions, strict=True))
            if plant.stands(index)
        }

    def stop(self, tick: int) -> None:
        """An emergency stop is in force: `brake` is called from now on."""

    def moving(self) -> frozenset[int]:
        """Robots that do not stand."""
        return frozenset(self.plant.ids) - self.resting().keys()

    def set_fleet(self, scenario: Scenario) -> None:
        """Robots came and went: a new one is at its start."""
        plant = self.plant
        for robot, length in zip(plant.ids, plant.lengths, strict=True):
            if robot not in scenario.ids:
                self._before[robot] = self._before.get(robot, 0.0) + length
        plant.set_fleet(scenario)
        self.sensors = {robot: self.sensors.get(robot) or Sensor(scenario, robot) for robot in scenario.ids}
        self._odometers = {
            robot: self._odometers.get(robot) or Odometer(scenario, robot, plant.slips)
            for robot in scenario.ids
        }
