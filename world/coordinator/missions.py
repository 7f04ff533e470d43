"""Missions: the points that robots are ordered to visit during a run; and the scenario's scheduled orders."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Protocol

from protocol.geometry import Shape
from protocol.messages import GoalStatus, OrderStatus, Standing, Vector
from protocol.operations import Outcome
from protocol.scenario.model import MOST_POINTS, Journey, Operation, Scenario
from world.coordinator.records import Mission


class Missions:
    """The missions of all robots of a scenario; each begins with the scenario's goal.

    An order takes effect with the next tick that is opened. A point is reached within the scenario's
    tolerance.

    Args:
        past: of an earlier world; the ordered ones, by robot.
        numbered: number of orders before.
    """

    def __init__(
        self, scenario: Scenario, past: Mapping[int, Mission] = MappingProxyType({}), numbered: int = 0
    ) -> None:
        self.numbered = numbered  # orders so far
        self._missions = dict(past)
        self._news: list[GoalStatus] = []
        self.set_fleet(scenario)

    @property
    def past(self) -> dict[int, Mission]:
        """The ordered missions, by robot, for a successor."""
        return {robot: mission for robot, mission in self._missions.items() if mission.number}

    def set_fleet(self, scenario: Scenario) -> None:
        """Set the robots, at first or after a change of the fleet."""
        known, self._scenario = self._missions, scenario
        self._missions = {
            robot: known.get(robot) or Mission((scenario.spec(robot).goal,)) for robot in scenario.ids
        }

    @property
    def pending(self) -> bool:
        """Whether any robot's order is unfinished."""
        return any(mission.ordered for mission in self._missions.values())

    def goal(self, robot: int) -> Vector | None:
        """Goal of a robot, m; None: the scenario's, or none after it has left."""
        mission = self._missions.get(robot)
        return mission.points[0] if mission is not None and mission.number else None

    def since(self, robot: int) -> int:
        """First tick by which a present robot has certainly received its goal."""
        mission = self._missions.get(robot)
        return mission.tick + 1 if mission is not None and mission.number else 0

    def status(self, robot: int) -> GoalStatus:
        mission = self._missions[robot]
        ahead = 0 if mission.patrol else len(mission.points) - 1
        return GoalStatus(robot, mission.tick, mission.number, mission.status, mission.points[0], ahead)

    def news(self) -> list[GoalStatus]:
        """Changes of order status since the last call."""
        news, self._news = self._news, []
        return news

    def refusal(
        self,
        order: Journey,
        standing: Iterable[Standing],
        obstacles: Mapping[int, Shape] = MappingProxyType({}),
    ) -> str:
        """The reason why an order is refused, among static disks and obstacles by number; "" if it is not."""
        robot = order.robot
        if robot not in self._missions:
            known = ", ".join(map(str, self._missions))
            return f"no robot {robot} in scenario {self._scenario.name!r}; there are {known}"
        if (order.queue or order.patrol or order.within is not None) and not order.points:
            return "an order without points cancels: leave out queue, patrol and within"
        ahead = len(self._missions[robot].points) if order.queue else 0
        if ahead + len(order.points) > MOST_POINTS:
            return f"a robot can have at most {MOST_POINTS} points; {ahead} are pending"
        others = [each for each in standing if each.robot != robot]
        radius = self._scenario.spec(robot).radius
        reasons = (obstruction(self._scenario, robot, radius, at, others, obstacles) for at in order.points)
        return next(filter(None, reasons), "")

    def accept(self, order: Journey, tick: int, position: Vector) -> Outcome:
        """Execute an order that is not refused, from `position` (m), at the start of `tick`."""
        robot = order.robot
        before = self._missions[robot]
        number = self.numbered = self.numbered + 1
        deadline = None if order.within is None else tick + self._scenario.ticks(order.within)
        if not order.points:
            self._missions[robot] = Mission((position,), number)
            self._set_status(robot, tick, "cancelled")
        else:
            ahead = before.points if order.queue and before.ordered else ()
            self._missions[robot] = Mission((*ahead, *order.points), number, order.patrol, deadline)
            self._set_status(robot, tick, "under way")
        return Outcome(True, number, self._caution(robot))

    def advance(self, tick: int, ids: Sequence[int], positions: Sequence[Vector]) -> list[int]:
        """As `tick` begins, continue after reached points; returns the robots with a new goal."""
        return [
            robot
            for robot, position in zip(ids, positions, strict=True)
            if self._missions[robot].ordered and self._proceed(robot, tick, position)
        ]

    def _proceed(self, robot: int, tick: int, position: Vector) -> bool:
        mission = self._missions[robot]
        if math.dist(position, mission.points[0]) <= self._scenario.time.tolerance:
            return self._reach(robot, mission, tick)
        if mission.deadline is not None and tick >= mission.deadline:
            mission.points = (position,)
            self._set_status(robot, tick, "given up")
            return True
        return False

    def _reach(self, robot: int, mission: Mission, tick: int) -> bool:
        """Record a reached point; returns whether there is another."""
        here, *ahead = mission.points
        if mission.patrol:
            ahead.append(here)
        if not ahead or (mission.patrol and len(ahead) == 1):
            self._set_status(robot, tick, "arrived")
            return False
        mission.points = tuple(ahead)
        self._set_status(robot, tick, "under way")
        return True

    def _set_status(self, robot: int, tick: int, status: OrderStatus) -> None:
        self._missions[robot].status, self._missions[robot].tick = status, tick
        self._news.append(self.status(robot))

    def covered(self, shape: Shape) -> str:
        """Warning that names the robots whose present goals an obstacle covers; "" if there are none."""
        robots = [
            robot
            for robot, mission in self._missions.items()
            if shape.distance(*mission.points[0]) <= self._scenario.spec(robot).radius
        ]
        return f"covers the goal of {_named(robots)}" if robots else ""

    def _caution(self, robot: int) -> str:
        """Warning that names the robots whose last points overlap that of a robot; "" if there are none."""
        point, radius = self._missions[robot].points[-1], self._scenario.spec(robot).radius
        near = [
            other
            for other, mission in self._missions.items()
            if other != robot
            and math.dist(point, mission.points[-1]) <= radius + self._scenario.spec(other).radius
        ]
        return f"overlaps the goal of {_named(near)}: they cannot all be there" if near else ""


def _named(robots: Sequence[int]) -> str:
    return f"robot{'s' if len(robots) > 1 else ''} {', '.join(map(str, robots))}"


def obstruction(
    scenario: Scenario,
    robot: int,
    radius: float,
    point: Vector,
    standing: Iterable[Standing],
    obstacles: Mapping[int, Shape],
) -> str:
    """Why the disk of a robot, of `radius` m, cannot be at a point (m); "" if it can."""
    where = f"({point[0]:g}, {point[1]:g})"
    beyond = scenario.workspace.shape.distance(*point) + radius
    if beyond >= 0.0:
        return f"{where}: robot {robot} would reach {beyond:.3g} m out of the workspace"
    for number, shape in obstacles.items():
        depth = radius - shape.distance(*point)
        if depth >= 0.0:
            return f"{where}: robot {robot} would overlap obstacle {number} by {depth:.3g} m"
    for each in standing:
        depth = radius + scenario.spec(each.robot).radius - math.dist(point, each.position)
        if depth >= 0.0:
            return f"{where}: robot {each.robot} is down and stands there, {depth:.3g} m too near"
    return ""


class Operated(Protocol):
    """Carries out operations: `world.world.WorldCore`."""

    def operate(self, operation: Operation, *, scheduled: bool = False) -> Outcome: ...


class Schedule:
    """The orders of a scenario, each executed as its tick opens.

    `past`: reasons of refusals, or "", of executed orders.
    """

    def __init__(self, scenario: Scenario, past: Sequence[str] = ()) -> None:
        due = [(scenario.ticks(order.at), order) for order in scenario.orders]
        self._due = deque(sorted(due, key=lambda entry: entry[0]))  # stable: as written within a tick
        # Tick, order, and the reason of a refusal or "", in order of execution.
        self.done = [(*self._due.popleft(), refused) for refused in past]

    @property
    def past(self) -> list[str]:
        return [refused for *_, refused in self.done]

    @property
    def pending(self) -> bool:
        """Whether orders are still to come."""
        return bool(self._due)

    def adds(self, robot: int) -> bool:
        """Whether a robot is still to be added."""
        return any(order.add is not None and order.add.id == robot for _, order in self._due)

    def carry_out(self, tick: int, operated: Operated) -> None:
        """Execute the orders that are due by `tick`."""
        while self._due and self._due[0][0] <= tick:
            _, order = self._due.popleft()
            outcome = operated.operate(order, scheduled=True)
            self.done.append((tick, order, "" if outcome.accepted else outcome.text))
