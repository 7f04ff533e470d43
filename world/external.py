"""External robots: they move by their own bases, and report their positions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Set

from protocol.errors import UsageError
from protocol.messages import Command, Report, Sense, Vector
from protocol.scenario.model import RobotSpec, Scenario
from protocol.scenario.places import SHARE, room_at_start
from world.plants.plant import PastDisks

STILL: Vector = (0.0, 0.0)
# Ticks that may take no time: the one in which something is heard, at its end, and one by which the clock of
# real time catches up with one that was late.
_HURRIED = 2
_HOPE = 5.0  # s after a base has come to rest, in which its robot may still learn more exactly where


class External:
    """In place of `world.simulation.SimulatedFleet`: an external fleet as its coordinator sees it.

    A robot moves only under its lease (`agents.bases.drive`). So a robot that was not heard for lease, hold
    and braking together stands, no further from its last report than it can have gone by then.

    Args:
        past: where an earlier world has left the robots, if there was one.
        tick: that is opened first; an earlier world may have told it, but no later one.

    Attributes:
        plant: the robots' disks as they are reported.
        bounds: by how much places are off, m, by robot id.
        unsettled: robots that stand, but have not reported where since they do, or not exactly.
        founding_bounds: by how much robots may be off their starts as they begin a run, or until they stand.
        largest_bound: of all reports so far, m.
    """

    def __init__(self, scenario: Scenario, past: PastDisks | None = None, tick: int = 0) -> None:
        if past is None:
            past = PastDisks(largest_bound=0.0)
        else:
            scenario = past.moved(scenario)
        self.plant = Reported(scenario, past)
        self.bounds: dict[int, float] = {}
        self.unsettled: Set[int] = frozenset()
        self.founding_bounds = past.bounds or {
            robot: SHARE * room_at_start(scenario, robot)[0] for robot in scenario.ids
        }
        self.largest_bound = past.largest_bound
        self._step, self._speed = (
            scenario.time.step,
            scenario.control.speed * (1.0 + scenario.actuation.bound),
        )
        self._tick = tick
        # Tick in which the newest Command came that gave a lease, by robot.
        self._heard = dict.fromkeys(past.moving, tick)
        self._stopped = 0  # first tick in which robots are told of the emergency stop
        self._still: dict[int, int] = {}  # since when each commands no motion because of it, ticks
        self._reports: dict[int, tuple[int, Report]] = {}  # newest of each robot, and its tick
        self._bodies = {robot: scenario.body_of(robot) for robot in scenario.ids}
        self._late = {robot: _late(scenario, robot) for robot in scenario.ids}  # s
        self._stops = {robot: _stopping(scenario, robot) for robot in scenario.ids}  # s
        self._lease = scenario.world.lease
        self._exact = {  # m
            spec.id: 2.0 * scenario.sensing_of(spec.id).bound + 0.1 * spec.radius for spec in scenario.robots
        }

    @property
    def places(self) -> dict[int, Vector]:
        """Where every disk's centre is by the newest report, m; before any, at its start."""
        return dict(zip(self.plant.ids, self.plant.positions, strict=True))

    @property
    def lengths(self) -> dict[int, float]:
        """Path length of every robot, m."""
        return dict(zip(self.plant.ids, self.plant.lengths, strict=True))

    @property
    def past(self) -> PastDisks:
        """The disks for a successor.

        A Command that arrives later gives no lease, for no Tick acknowledges it any more.
        """
        bounds = {**self.founding_bounds, **{robot: self._off(robot) for robot in self._reports}}
        return PastDisks(self.places, {}, self.lengths, bounds, tuple(self._heard), self.largest_bound)

    def sense(self, tick: int) -> dict[int, Sense]:
        """Nothing: external bases measure themselves."""
        self._tick = tick
        return {}

    @property
    def measurements(self) -> dict[str, int]:
        """How many measurements came late, were missing, or were dropped: none is made here."""
        return {"delayed": 0, "missing": 0, "dropped": 0}

    def hear(self, command: Command) -> None:
        """A robot commands itself in a tick, and says where it was as that began, if it knows."""
        robot, tick, report = command.robot, command.tick, command.report
        sent = max(tick, self._tick)  # by then, however late the tick that it is of
        if command.may_move:  # only such a Command gives a lease
            self._heard[robot] = sent
        if tick >= self._stopped and command.velocity == STILL:  # it takes in no earlier Tick any more
            self._still.setdefault(robot, sent)
        if report is not None:
            self._reports[robot] = tick, report
            self.largest_bound = max(self.largest_bound or 0.0, report.bound)
            self.plant.put(robot, report.position)

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """A tick is over; robots obey their own commands."""

    def brake(self, tick: int) -> None:
        """A tick is over in which robots were told to stand."""

    def resting(self) -> dict[int, Vector]:
        """Where robots stand that were not heard for so long that they surely do, m, by robot id."""
        self.bounds = {}
        resting, unsettled = {}, set()
        for robot, (_, report) in self._reports.items():
            heard = self._heard.get(robot)
            if heard is None or (self._tick - heard - _HURRIED) * self._step >= self._leased(robot):
                self.bounds[robot], resting[robot] = self._off(robot), report.position
                if self._moved(robot) > 0.0 or (report.bound > self._exact[robot] and self._hopes(robot)):
                    unsettled.add(robot)
        self.unsettled = unsettled
        return resting

    def _hopes(self, robot: int) -> bool:
        """Whether a robot that stands may soon know better where: a place once settled stays as large."""
        heard = self._heard.get(robot)
        return heard is not None and (self._tick - heard) * self._step < self._leased(robot) + _HOPE

    def _leased(self, robot: int) -> float:
        """For how long a base may move after the newest Command that gave a lease, s."""
        return self._lease + self._stops[robot]

    def _moved(self, robot: int) -> float:
        """For how long a robot may have moved since its newest report, whose odometry was late, until another
        Command is heard, s."""
        tick, heard = self._reports[robot][0], self._heard.get(robot)
        moving = self._leased(robot) + self._late[robot]
        return 0.0 if heard is None else (heard + _HURRIED - tick) * self._step + moving

    def _off(self, robot: int) -> float:
        """By how much it may be off that report then, m."""
        bound, moved = self._reports[robot][1].bound, self._moved(robot)
        return bound + self._farthest(robot, moved) if moved > 0.0 else bound

    def stop(self, tick: int) -> None:
        """An emergency stop is in force, of which robots are told from `tick` on."""
        self._stopped, self._still = tick, {}

    def moving(self) -> frozenset[int]:
        """Robots that may not stand yet: those that have not obeyed the emergency stop for as long as their
        bases need to brake, and are not silent for so long that they surely stand."""
        silent = self.resting().keys() | (set(self.plant.ids) - self._heard.keys())
        still = {
            robot
            for robot, tick in self._still.items()
            if (self._tick - tick - _HURRIED) * self._step >= self._stops[robot]
        }
        return frozenset(self.plant.ids) - silent - still

    def _farthest(self, robot: int, seconds: float) -> float:
        """How far a robot goes at most in a time, m."""
        body, speed = self._bodies[robot], self._speed
        return speed * seconds * (1.0 + body.error) + body.play

    def set_fleet(self, scenario: Scenario) -> None:  # noqa: ARG002
        """The set of robots is fixed."""
        raise UsageError(self.plant.fixed)


class Reported:
    """A `world.plants.plant.Plant` of reported positions."""

    parts = 1
    slips = True
    fixed = "external robots neither come nor go: stop the run, and begin another"

    def __init__(self, scenario: Scenario, past: PastDisks) -> None:
        self.ids = scenario.ids
        self.positions: list[Vector] = [scenario.spec(robot).start for robot in self.ids]
        self.lengths = [past.ways.get(robot, 0.0) for robot in self.ids]
        self.between: list[tuple[Vector, ...]] = []
        self._known = set(past.moving)

    def put(self, robot: int, position: Vector) -> None:
        """A robot is there."""
        index = self.ids.index(robot)
        if robot in self._known:
            self.lengths[index] += math.dist(self.positions[index], position)
        self._known.add(robot)
        self.positions[index] = position

    def refusal(self, spec: RobotSpec) -> str:  # noqa: ARG002
        """See `world.plants.plant.Plant`."""
        return self.fixed

    def touched(self) -> tuple[()]:
        """No contact is sensed."""
        return ()


def _late(scenario: Scenario, robot: int) -> float:
    """Time before a report at which its odometry may have been made, with the lag of the wheels, s."""
    base = scenario.base_of(robot)
    return scenario.body_of(robot).lag + (0.0 if base is None else base.lateness.age)


def _stopping(scenario: Scenario, robot: int) -> float:
    """Time in which a robot's base stands when it is left alone, s."""
    body = scenario.body_of(robot)
    return body.hold + body.speed / body.acceleration
