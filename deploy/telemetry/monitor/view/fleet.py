"""A running fleet as a watcher sees it: messages and presence in, plain data for a page or table out.

Only streams that the network may drop are needed (clock, truth, health, goalstatus) and liveliness tokens: a
watcher that subscribed to states or commands could hold up those who publish them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Set

from deploy.telemetry.monitor.admin_space import Router
from deploy.telemetry.monitor.view.robot import RobotView
from deploy.telemetry.scene.cast import Cast
from deploy.telemetry.scene.thinned import Thinned
from protocol.messages import Clock, GoalStatus, Health, Message, Thing, Truth
from protocol.requests.steering import Steering
from protocol.scenario.model import RobotSpec, Scenario

HISTORY = 1024  # kept points of clearance and phi
_TRAILS = 12_800  # kept points of all trails together
_RECENT = 256  # truths between two snapshots, at most
_NEAR = 8  # radii; lines to who is farther away are not shown

Point = tuple[float, float, float]  # simulated time, s; clearance, m; phi


def _worst(earlier: Point, later: Point) -> Point:
    """Two points as one: the clearance that matters is the smaller one."""
    return later[0], min(earlier[1], later[1]), later[2]


class View:
    """Everything known of one run. `now` is the watcher's own clock, s; only differences matter."""

    def __init__(self, run: str) -> None:
        self.run = run
        self.scenario: Scenario | None = None
        self.lockstep = True
        self.epoch = 0  # counts the scenarios seen under this run name, and who came or went meanwhile
        self.steering = Steering()
        self.router: Router | None = None  # where its admin space is on
        self.robots: dict[int, RobotView] = {}
        self.world_alive: bool | None = None
        self._tokens: dict[int, bool] = {}
        self._cast: Cast | None = None
        self._trail = 0  # places of each robot that are kept
        self._clear()

    def _clear(self) -> None:
        self.tick, self.verdict, self.reason = 0, "", ""
        self.missed, self.rejected = 0, dict[str, int]()
        self.halted = False  # by an emergency stop
        self.smallest: float | None = None
        self.things: tuple[Thing, ...] = ()  # that came or went
        self.history: Thinned[Point] = Thinned(HISTORY, _worst)
        self.recent: deque[Truth] = deque(maxlen=_RECENT)
        self._pace: deque[tuple[float, int]] = deque(maxlen=32)

    def begin(self, scenario: Scenario, lockstep: bool, goals: Iterable[GoalStatus] = ()) -> None:
        """A scenario begins, or this watcher has just learnt which one is running, and who was ordered
        elsewhere."""
        self._clear()
        self.epoch += 1
        self.scenario, self.lockstep = scenario, lockstep
        self._trail = max(32, _TRAILS // len(scenario.robots))
        self._cast = Cast(scenario)
        first = 1 if self.epoch == 1 else None  # later scenarios count on from the lives before
        self.robots = {robot: RobotView(scenario.spec(robot), self._trail, first) for robot in scenario.ids}
        for robot, alive in self._tokens.items():
            if robot in self.robots:
                self.robots[robot].alive = alive
        for status in goals:
            self._on_goal(status)

    def meet(self, scenario: Scenario, goals: Iterable[GoalStatus] = ()) -> None:
        """Take over what the world says of strangers; the next truth shows them."""
        if self._cast is not None:
            self._cast.meet(scenario)
        for status in goals:
            self._on_goal(status)

    @property
    def strangers(self) -> Set[int]:
        """Whose disks are there, and of whom nothing is known."""
        return frozenset() if self._cast is None else self._cast.strangers

    def is_news(self, message: Message) -> bool:
        """Whether `message` belongs to another scenario than the one known: its clock went back."""
        return isinstance(message, Clock) and (
            message.tick < self.tick or self.verdict > message.verdict == ""
        )

    # -- what happens

    def present(self, robot: int | None, alive: bool) -> None:
        """A liveliness token came or went; `robot` is None for the world's."""
        if robot is None:
            self.world_alive = alive
            return
        if self.scenario is not None and robot not in self.robots and robot not in self.strangers:
            return  # nobody of this run
        self._tokens[robot] = alive
        if robot in self.robots and not self.verdict:  # at the end everybody leaves, and that is well
            self.robots[robot].alive = alive

    def on_message(self, message: Message, now: float) -> None:
        """Something was published; ignored while the scenario is unknown."""
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

    def _on_clock(self, clock: Clock) -> None:
        self.tick, self.verdict, self.reason = max(self.tick, clock.tick), clock.verdict, clock.reason
        self.missed, self.rejected = clock.missed, clock.rejected
        self.things, self.halted = clock.things, clock.halted
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
        if truth.tick <= known:
            return
        self._recast(truth)
        elapsed = (truth.tick - known) * step if known or truth.tick == 1 else 0.0
        for robot, position in zip(truth.robots, truth.positions, strict=False):
            if robot in self.robots:
                self._moved(self.robots[robot], position, elapsed, truth.tick, now)
        self.smallest = truth.clearance if self.smallest is None else min(self.smallest, truth.clearance)
        self.history.append((truth.tick * step, truth.clearance, truth.phi))
        self.recent.append(truth)
        self.tick = max(self.tick, truth.tick)

    def _recast(self, truth: Truth) -> None:
        """See who is there; whoever shows them begins anew if that has changed."""
        assert self._cast is not None
        came, went = self._cast.see(truth)
        for robot in went:
            del self.robots[robot]
            self._tokens.pop(robot, None)
        for robot in came:
            radius, place = self._cast.radii[robot], self._cast.places[robot]
            spec = RobotSpec(robot, radius, place, self._cast.goals[robot])
            self.robots[robot] = RobotView(spec, self._trail, None)
            self.robots[robot].alive = self._tokens.get(robot)
        if came or went:
            self.robots = dict(sorted(self.robots.items()))
            self.epoch += 1

    def _moved(
        self, robot: RobotView, position: tuple[float, float], elapsed: float, tick: int, now: float
    ) -> None:
        robot.moved(position, elapsed)
        if self.lockstep and robot.active and robot.alive is not False:
            robot.said(tick - 1, now)  # a lock-step tick ends only when everybody active has stated

    def _on_health(self, health: Health, now: float) -> None:
        if health.robot in self.robots:
            robot = self.robots[health.robot]
            robot.report(health, now)
            robot.lines = tuple(line for line in health.lines if self._is_near(robot, line[0]))
        for peer, tick in health.heard:
            if peer in self.robots:
                self.robots[peer].said(tick, now)

    def _is_near(self, robot: RobotView, peer: int) -> bool:
        reach = _NEAR * robot.spec.radius
        return peer in self.robots and math.dist(robot.position, self.robots[peer].position) < reach

    def _on_goal(self, status: GoalStatus) -> None:
        if status.robot in self.robots:
            self.robots[status.robot].ordered(status)

    # -- how the run stands

    @property
    def phase(self) -> str:
        """searching, gathering, running, paused, halted: by an emergency stop, ended, or lost: the world
        went without a verdict."""
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
        """Since about a second ago, if somebody asked then."""
        while len(self._pace) > 1 and self._pace[1][0] < now - 1.0:
            self._pace.popleft()
        self._pace.append((now, self.tick))
        then, tick = self._pace[0]
        return round((self.tick - tick) / (now - then), 1) if now > then else 0.0
