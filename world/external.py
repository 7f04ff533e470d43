"""External robots: they move by their own bases, and report their positions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Set

from protocol.errors import UsageError
from protocol.messages import STILL, Command, Report, Sense, Vector
from protocol.scenario.model import RobotSpec, Scenario
from protocol.scenario.places import SHARE, room_at_start
from world.plants.plant import PastDisks

# Ticks that may take no time: the one at whose end a message is received, and one by which the clock of
# real time catches up with one that was late.
_HURRIED = 2
_HOPE = 5.0  # s after a stop in which the robot may still improve its position


class External:
    """An external fleet as its coordinator sees it, in place of `world.simulation.SimulatedFleet`.

    A robot moves only under its lease (`agents.bases.drive`). So a robot that has been silent for lease, hold
    and braking together stands, no further from its last report than it can have moved by then.

    Args:
        past: the robots at the end of an earlier world, if there was one.
        tick: opened first; an earlier world may have opened it, but no later one.
    """

    def __init__(self, scenario: Scenario, past: PastDisks | None = None, tick: int = 0) -> None:
        if past is None:
            past = PastDisks(largest_bound=0.0)
        else:
            scenario = past.moved(scenario)
        self.plant = Reported(scenario, past)
        self.bounds: dict[int, float] = {}  # errors of positions, m, by robot id
        # Robots that stand without a report of that position, or with an inexact one.
        self.unsettled: Set[int] = frozenset()
        # Distances from their starts at the beginning of a run, or until they stand, m.
        self.founding_bounds = past.bounds or {
            robot: SHARE * room_at_start(scenario, robot)[0] for robot in scenario.ids
        }
        self.largest_bound = past.largest_bound  # of all reports so far, m
        self._step, self._speed = (
            scenario.time.step,
            scenario.control.speed * (1.0 + scenario.actuation.bound),
        )
        self._tick = tick
        # Tick of the newest Command that gave a lease, by robot.
        self._heard = dict.fromkeys(past.moving, tick)
        self._stopped = 0  # first tick with the emergency stop
        self._still: dict[int, int] = {}  # tick since which each commands no motion because of it
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
        """Newest reported position of every disk's centre, m; its start before the first report."""
        return dict(zip(self.plant.ids, self.plant.positions, strict=True))

    @property
    def lengths(self) -> dict[int, float]:
        """Path length of every robot, m."""
        return dict(zip(self.plant.ids, self.plant.lengths, strict=True))

    @property
    def past(self) -> PastDisks:
        """The disks for a successor. Later Commands give no lease, since no Tick acknowledges them."""
        bounds = {**self.founding_bounds, **{robot: self._off(robot) for robot in self._reports}}
        return PastDisks(self.places, {}, self.lengths, bounds, tuple(self._heard), self.largest_bound)

    def sense(self, tick: int) -> dict[int, Sense]:
        """Nothing: external bases have their own sensors."""
        self._tick = tick
        return {}

    @property
    def measurements(self) -> dict[str, int]:
        """Numbers of late, missing and dropped measurements: none."""
        return {"delayed": 0, "missing": 0, "dropped": 0}

    def on_command(self, command: Command) -> None:
        """Receive a robot's Command of a tick, with its position at the beginning of that tick, if known."""
        robot, tick, report = command.robot, command.tick, command.report
        sent = max(tick, self._tick)  # by then, even if its tick is late
        if command.may_move:  # only this Command gives a lease
            self._heard[robot] = sent
        if tick >= self._stopped and command.velocity == STILL:  # it accepts no earlier Tick
            self._still.setdefault(robot, sent)
        if report is not None:
            self._reports[robot] = tick, report
            self.largest_bound = max(self.largest_bound or 0.0, report.bound)
            self.plant.put(robot, report.position)

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """End a tick, whose commands robots execute themselves."""

    def brake(self, tick: int) -> None:
        """End a tick in which robots were ordered to stand."""

    def resting(self) -> dict[int, Vector]:
        """Positions of robots that certainly stand after long silence, m, by robot id."""
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
        """Whether a standing robot may soon report a better position."""
        heard = self._heard.get(robot)
        return heard is not None and (self._tick - heard) * self._step < self._leased(robot) + _HOPE

    def _leased(self, robot: int) -> float:
        """Time for which a base may move after the newest Command that gave a lease, s."""
        return self._lease + self._stops[robot]

    def _moved(self, robot: int) -> float:
        """Time for which a robot may have moved since its newest report, without another Command, s."""
        tick, heard = self._reports[robot][0], self._heard.get(robot)
        moving = self._leased(robot) + self._late[robot]
        return 0.0 if heard is None else (heard + _HURRIED - tick) * self._step + moving

    def _off(self, robot: int) -> float:
        """Error of that report after this time, m."""
        bound, moved, body = self._reports[robot][1].bound, self._moved(robot), self._bodies[robot]
        return bound + (self._speed * moved * (1.0 + body.error) + body.play) if moved > 0.0 else bound

    def stop(self, tick: int) -> None:
        """Note that an emergency stop is in force from `tick` on."""
        self._stopped, self._still = tick, {}

    def moving(self) -> frozenset[int]:
        """Robots that may still move: they have neither obeyed the emergency stop for their braking time, nor
        been silent for so long that they certainly stand.
        """
        silent = self.resting().keys() | (set(self.plant.ids) - self._heard.keys())
        still = {
            robot
            for robot, tick in self._still.items()
            if (self._tick - tick - _HURRIED) * self._step >= self._stops[robot]
        }
        return frozenset(self.plant.ids) - silent - still

    def set_fleet(self, scenario: Scenario) -> None:  # noqa: ARG002
        """The set of robots is fixed."""
        raise UsageError(self.plant.fixed)


class Reported:
    """A `world.plants.plant.Plant` of reported positions."""

    parts = 1
    slips = True
    fixed = "external robots cannot be added or removed during a run: start another run"

    def __init__(self, scenario: Scenario, past: PastDisks) -> None:
        self.ids = scenario.ids
        self.positions: list[Vector] = [scenario.spec(robot).start for robot in self.ids]
        self.lengths = [past.ways.get(robot, 0.0) for robot in self.ids]
        self.between: list[tuple[Vector, ...]] = []
        self._known = set(past.moving)

    def put(self, robot: int, position: Vector) -> None:
        """Set a robot's position."""
        index = self.ids.index(robot)
        if robot in self._known:
            self.lengths[index] += math.dist(self.positions[index], position)
        self._known.add(robot)
        self.positions[index] = position

    def refusal(self, spec: RobotSpec) -> str:  # noqa: ARG002
        """See `world.plants.plant.Plant`."""
        return self.fixed

    def touched(self) -> tuple[()]:
        return ()


def _late(scenario: Scenario, robot: int) -> float:
    """Greatest age of a report's odometry, with the lag of the wheels, s."""
    base = scenario.base_of(robot)
    return scenario.body_of(robot).lag + (0.0 if base is None else base.lateness.age)


def _stopping(scenario: Scenario, robot: int) -> float:
    """Time to a stop of a robot's base without commands, s."""
    body = scenario.body_of(robot)
    return body.hold + body.speed / body.acceleration
