"""A running fleet as a watcher sees it: messages and tokens in, one row per robot out.

It needs only liveliness tokens and streams that the network may drop (clock, truth, health, goalstatus), so
that no watcher can block publishers of States or Commands. Ticks, which a recorder also receives, give the
radii of robots that operators add.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Set
from typing import Any, Generic, TypeVar

from protocol.geometry import Shape
from protocol.messages import (
    Clock,
    GoalStatus,
    Health,
    Line,
    Message,
    PlacedObstacle,
    Tick,
    Truth,
    Vector,
)
from protocol.operations import Steering
from protocol.scenario.model import RobotSpec, Scenario

SILENCE = 1.5  # s without a message, while its peers go on, after which a robot is silent
ALARMS = ("dead", "fenced", "silent")
ABANDONED = ("cancelled", "given up")  # the robot stays at its place
_DIGITS = 6  # decimals of a metre
T = TypeVar("T")


class Thinned(Generic[T]):
    """At most `limit` entries (even), each standing for equally many appended ones.

    When full, pairs of neighbours are merged by `merge(earlier, later)`; the last entry may still grow.
    """

    def __init__(self, limit: int, merge: Callable[[T, T], T]) -> None:
        self.items: list[T] = []
        self._limit, self._merge = limit + limit % 2, merge
        self._stride = 1  # appended entries per kept one
        self._count = 0

    def append(self, item: T) -> None:
        if self._count % self._stride:
            self.items[-1] = self._merge(self.items[-1], item)
        else:
            if len(self.items) == self._limit:
                pairs = zip(self.items[::2], self.items[1::2], strict=True)
                self.items = [self._merge(earlier, later) for earlier, later in pairs]
                self._stride *= 2
            self.items.append(item)
        self._count += 1


class RobotView:
    """One robot as the watcher sees it; times are seconds of the watcher's clock.

    Args:
        spec: the robot in the scenario.
        trail: number of past places to keep.
        first: incarnation of its first life in this scenario; None: the first one received.
        aims: whether the goal of `spec` is known to be its goal.
    """

    def __init__(self, spec: RobotSpec, trail: int, first: int | None = 1, *, aims: bool = True) -> None:
        self.spec = spec
        self.radius = spec.radius  # m, of its disk, with a carried part
        self.alive: bool | None = None  # whether its token exists; None: none seen yet
        self.fenced = False
        self.active = False
        self.incarnation = 0
        self.tick = 0  # of its newest State, as known from Health and Truth
        self.health: Health | None = None
        self.lines: tuple[Line, ...] = ()  # obeyed towards near peers, by its latest Health
        self.errand = GoalStatus(spec.id, 0, 0, "under way", spec.goal)
        self.position: Vector = spec.start
        self.velocity: Vector = (0.0, 0.0)
        self.trail: Thinned[Vector] = Thinned(trail, lambda _, later: later)
        self._first, self._aims = first, aims
        self._seen: float | None = None
        self._reported = 0.0
        self._rate: float | None = None

    def on_state(self, tick: int, now: float) -> None:
        """Note that a message shows this robot's State of `tick`."""
        if tick > self.tick or self._seen is None:
            self.tick, self._seen = tick, now

    def on_health(self, health: Health, now: float) -> None:
        """Take the robot's Health; one from an earlier life is ignored."""
        if health.incarnation < self.incarnation:
            return
        if health.incarnation > self.incarnation:
            self.incarnation, self._rate = health.incarnation, None
            self._first = health.incarnation if self._first is None else self._first
        elif self.health is not None and now > self._reported:
            # A robot publishes two messages a tick: State and Command.
            self._rate = max(0, health.published - self.health.published) / 2.0 / (now - self._reported)
        self.health, self._reported = health, now
        self.on_state(health.tick, now)

    def on_goal(self, status: GoalStatus) -> None:
        """Take the status of an order, unless a newer one is known."""
        if (status.number, status.tick) >= (self.errand.number, self.errand.tick):
            self.errand, self._aims = status, True

    def move(self, position: Vector, seconds: float) -> None:
        """Take the true position, `seconds` of simulated time after the previous one."""
        x, y = self.position
        if seconds > 0.0:
            self.velocity = ((position[0] - x) / seconds, (position[1] - y) / seconds)
        self.position = position
        self.trail.append(position)

    @property
    def restarts(self) -> int:
        """Number of lives after the first."""
        return max(0, self.incarnation - (self._first or 0)) if self.incarnation else 0

    @property
    def goal(self) -> Vector | None:
        """Present goal, m; None if no message gave it."""
        return self.errand.goal if self._aims else None

    @property
    def distance(self) -> float:
        """Distance to the present goal, m."""
        return math.dist(self.position, self.errand.goal)

    def age(self, now: float) -> float | None:
        """Age of its newest State, s; None before the first."""
        return None if self._seen is None else max(0.0, now - self._seen)

    def status(self, now: float, newest: int, tolerance: float, *, ended: bool) -> str:
        """Status in one word; those in `ALARMS` are alarms.

        `newest`: tick of the newest State of all robots. `ended`: there is a verdict.
        """
        if self.fenced and not self.active:
            return "fenced"
        if self.alive is False:
            return "dead"
        if not ended and self._seen is None and not self.active:
            return "joining" if self.alive else "absent"
        if not ended and self.tick < newest and (self.age(now) or 0.0) > SILENCE:
            return "silent"
        if self.distance <= tolerance:
            return self.errand.status if self.errand.status in ABANDONED else "at goal"
        return "stopped" if ended else "under way"

    def row(self, now: float, newest: int, tolerance: float, *, ended: bool) -> dict[str, Any]:
        """Row of the table; arguments as of `status`."""
        health, age = self.health, self.age(now)
        status = self.status(now, newest, tolerance, ended=ended)
        silent = age is None or age > SILENCE
        return {
            "id": self.spec.id,
            "status": status,
            "alarm": status in ALARMS,
            "alive": self.alive,
            "radius": self.radius,
            "velocity": [round(part, _DIGITS) for part in self.velocity],
            "distance": round(self.distance, _DIGITS),
            "goal": self.errand.goal,
            "ahead": self.errand.ahead,
            "age": None if age is None else round(age, 2),
            "age_ticks": None if age is None else newest - self.tick,
            "rate": 0.0 if silent else self._rate,
            "bound": None if health is None else health.bound,
            "rejected": 0 if health is None else sum(health.rejected.values()),
            "reasons": {} if health is None else health.rejected,
            "restarts": self.restarts,
            "lines": self.lines,
            "lines_tick": None if health is None else health.tick,
        }


HISTORY = 1024  # kept points of clearance and potential
_TRAILS = 12_800  # kept points of all trails together
_RECENT = 256  # Truths between two snapshots
_LATEST = float(1 << 31)  # s of simulated time, the end of viewers' time
_NEAR = 8  # radii; lines to robots farther away are not shown

# The messages of which a view is made.
VIEWED = frozenset((Clock, Truth, Health, GoalStatus, Tick))
HistoryPoint = tuple[float, float, float]  # simulated time, s; clearance, m; log_potential


def _worst(earlier: HistoryPoint, later: HistoryPoint) -> HistoryPoint:
    return later[0], min(earlier[1], later[1]), later[2]


class FleetView:
    """Everything known of one run, with the `recent` newest Truths. `now` is the watcher's clock, s, of which
    only differences matter.
    """

    def __init__(self, run: str, recent: int = _RECENT) -> None:
        self.run, self._recent = run, recent
        self.scenario: Scenario | None = None
        self.lockstep = True
        self.epoch = 0  # counts scenarios under this run name, and changes of membership
        self.steering = Steering()
        self.robots: dict[int, RobotView] = {}
        self.world_alive: bool | None = None
        self._tokens: dict[int, bool] = {}
        self._trail = 0  # number of past places kept for each robot
        self._clear()

    def _clear(self) -> None:
        self.tick, self.verdict, self.reason = 0, "", ""
        self.missed, self.rejected = 0, dict[str, int]()
        self.halted, self.stops = False, 0  # an emergency stop is in force; number of them so far
        self.smallest: float | None = None
        self.obstacles: tuple[PlacedObstacle, ...] = ()  # placed or removed during the run
        self.history: Thinned[HistoryPoint] = Thinned(HISTORY, _worst)
        self.recent: deque[Truth] = deque(maxlen=self._recent)
        self.strangers: Set[int] = frozenset()  # present disks of which no message gave the radius
        self._newcomers: tuple[RobotSpec, ...] = ()
        self._announced: dict[int, float] = {}  # radii by rosters, m
        self._shown: tuple[int, ...] = ()  # robots of the newest Truth
        self._pace: deque[tuple[float, int]] = deque(maxlen=32)

    def begin(self, scenario: Scenario, lockstep: bool, goals: Iterable[GoalStatus] = ()) -> None:
        """Start a view of a scenario, with the goals that replace those in it."""
        self._clear()
        self.epoch += 1
        self.scenario, self.lockstep = scenario, lockstep
        self._trail = max(32, _TRAILS // len(scenario.robots))
        self._newcomers, self._shown = scenario.newcomers, scenario.ids
        first = 1 if self.epoch == 1 else None  # incarnations count on in later scenarios
        self.robots = {robot: RobotView(scenario.spec(robot), self._trail, first) for robot in scenario.ids}
        for robot, alive in self._tokens.items():
            if robot in self.robots:
                self.robots[robot].alive = alive
        for status in goals:
            self._on_goal(status)

    def update(self, scenario: Scenario, goals: Iterable[GoalStatus] = ()) -> None:
        """Take the specs of strangers from the world's present scenario; the next Truth shows them."""
        self._newcomers += tuple(spec for spec in scenario.robots if spec.id in self.strangers)
        self._shown, self.strangers = (), frozenset()
        for status in goals:
            self._on_goal(status)

    def is_news(self, message: Message) -> bool:
        """Whether `message` belongs to another scenario, since its clock is behind."""
        return isinstance(message, Clock) and (
            message.tick < self.tick or self.verdict > message.verdict == ""
        )

    # -- events

    def on_token(self, robot: int | None, alive: bool) -> None:
        """Note that a liveliness token appeared or went; `robot` is None for the world's."""
        if robot is None:
            self.world_alive = alive
            return
        if self.scenario is not None and robot not in self.robots and robot not in self.strangers:
            return  # no robot of this run
        self._tokens[robot] = alive
        if robot in self.robots and not self.verdict:  # at the end all robots leave
            self.robots[robot].alive = alive

    def on_message(self, message: Message, now: float) -> None:
        """Take a published message; ignored while the scenario is unknown."""
        if self.scenario is None:
            return
        if isinstance(message, Clock):
            self._on_clock(message)
        elif isinstance(message, Truth):
            self._on_truth(message, now)
        elif isinstance(message, Health):
            self._on_health(message, now)
        elif isinstance(message, GoalStatus):
            self._on_goal(message)
        elif isinstance(message, Tick) and message.roster is not None:
            for each in message.roster.members:
                if each.status != "gone" and each.robot not in self.robots:
                    self._announced[each.robot], self._shown = each.radius, ()

    def _on_clock(self, clock: Clock) -> None:
        self.tick, self.verdict, self.reason = max(self.tick, clock.tick), clock.verdict, clock.reason
        self.smallest = clock.clearance if self.smallest is None else min(self.smallest, clock.clearance)
        self.missed, self.rejected = clock.missed, clock.rejected
        self.obstacles, self.halted, self.stops = clock.obstacles, clock.halted, clock.stops
        down = {each.robot for each in clock.standing}
        active = frozenset(clock.active)
        carried = {place.carrier: place.part for place in clock.parts if place.carrier}
        for robot, view in self.robots.items():
            view.fenced, view.active = robot in down, robot in active
            view.radius = view.spec.radius
            if self.scenario is not None and robot in carried:
                view.radius = max(view.radius, self.scenario.parts[carried[robot] - 1].radius)

    def _on_truth(self, truth: Truth, now: float) -> None:
        assert self.scenario is not None
        step = self.scenario.time.step
        known = self.recent[-1].tick if self.recent else 0
        if truth.tick <= known or truth.tick * step >= _LATEST:
            return
        self._set_fleet(truth)
        elapsed = (truth.tick - known) * step if known or truth.tick == 1 else 0.0
        for robot, position in zip(truth.robots, truth.positions, strict=False):
            if (view := self.robots.get(robot)) is not None:
                view.move(position, elapsed)
                if self.lockstep and view.active and view.alive is not False:
                    # The tick ended once all active robots had sent States.
                    view.on_state(truth.tick - 1, now)
        self.history.append((truth.tick * step, truth.clearance, truth.log_potential))
        self.recent.append(truth)
        self.tick = max(self.tick, truth.tick)

    def _set_fleet(self, truth: Truth) -> None:
        """Add robots that appeared and delete those that left; viewers then redraw everything."""
        if truth.robots == self._shown:
            return
        self._shown = truth.robots
        places = dict(zip(truth.robots, truth.positions, strict=False))
        known = self.robots.keys() | {spec.id for spec in self._newcomers} | self._announced.keys()
        self.strangers = frozenset(truth.robots) - known
        before = self.robots
        self.robots = {
            robot: before[robot] if robot in before else self._newcomer(robot, place)
            for robot, place in sorted(places.items())
            if robot in known
        }
        for robot in before.keys() - self.robots.keys():  # another robot may get this id
            self._tokens.pop(robot, None)
            self._announced.pop(robot, None)
        self.epoch += before.keys() != self.robots.keys()

    def _newcomer(self, robot: int, place: Vector) -> RobotView:
        """A robot that appeared; of several orders for its id, by that with the nearest start."""
        specs = [spec for spec in self._newcomers if spec.id == robot]
        spec = min(specs, key=lambda each: math.dist(each.start, place), default=None)
        size, goal = (self._announced[robot], place) if spec is None else (spec.radius, spec.goal)
        view = RobotView(RobotSpec(robot, size, place, goal), self._trail, None, aims=spec is not None)
        view.alive = self._tokens.get(robot)
        return view

    def _on_health(self, health: Health, now: float) -> None:
        if health.robot in self.robots:
            robot = self.robots[health.robot]
            robot.on_health(health, now)
            robot.lines = tuple(line for line in health.lines if self._is_near(robot, line[0]))
        for peer, tick in health.heard:
            if peer in self.robots:
                self.robots[peer].on_state(tick, now)

    def _is_near(self, robot: RobotView, peer: int) -> bool:
        reach = _NEAR * robot.spec.radius
        return peer in self.robots and math.dist(robot.position, self.robots[peer].position) < reach

    def _on_goal(self, status: GoalStatus) -> None:
        if status.robot in self.robots:
            self.robots[status.robot].on_goal(status)

    # -- state of the run

    @property
    def shapes(self) -> dict[int, Shape]:
        """Present obstacles, by number."""
        listed = {} if self.scenario is None else self.scenario.shapes
        changed = {each.number for each in self.obstacles}
        there = {each.number: each.shape for each in self.obstacles if each.status == "standing"}
        return {number: shape for number, shape in listed.items() if number not in changed} | there

    @property
    def phase(self) -> str:
        """searching, gathering, running, paused, halted, ended, or lost: no world and no verdict."""
        if self.scenario is None:
            return "searching"
        if self.verdict:
            return "ended"
        if self.world_alive is False:
            return "lost"
        if self.halted:
            return "halted"
        if self.steering.paused:
            return "paused"
        return "running" if self.recent or self.tick else "gathering"

    def ticks_per_second(self, now: float) -> float:
        """Rate over the calls of about the last second."""
        while len(self._pace) > 1 and self._pace[1][0] < now - 1.0:
            self._pace.popleft()
        self._pace.append((now, self.tick))
        then, tick = self._pace[0]
        return round((self.tick - tick) / (now - then), 1) if now > then else 0.0
