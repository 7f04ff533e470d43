"""Whole robots in a world: each drives at another, at an obstacle or the wall, and all that can fail does.

World, robots, and all that is in them are the real ones; only the law is replaced by one that wants to
collide. The model is what lies between: processes that die, sleep and wake over an old queue, come late, talk
on though they are fenced; and messages that are lost, late, repeated and reordered.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from random import Random
from typing import Any

from agents.peers.far import SummaryPlaces
from agents.peers.state import addressed_to
from protocol.messages import Command, State, Tick, Vector
from protocol.scenario.model import Operation, Scenario
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.skirmishes import arena
from tests.agents.lines.models.skirmishes.arena import Attack

TICKS = 40


def violation_of(seed: int, product: Product, ticks: int = TICKS) -> str:
    """What goes wrong in the run with this seed; "" if nothing does."""
    return first_violation(Skirmish(seed, product), ticks)


def first_violation(run: Skirmish, ticks: int) -> str:
    """What goes wrong first in so many ticks of a run; "" if nothing does."""
    for _ in range(ticks):
        run.tick()
        violation = run.violation()
        if violation:
            return f"in tick {run.world.tick - 1}: {violation}"
    return ""


class Skirmish:
    def __init__(self, seed: int, product: Product) -> None:
        rng = self.rng = Random(seed)
        self.product, self.scenario = product, self._drawn(seed, rng)
        self.world = product.World(self.scenario)
        self.processes: dict[int, _Process] = {}
        self.former: list[_Process] = []
        self.under_way: list[tuple[int, State, int]] = []  # tick of arrival, State, receiver
        self.late: list[Command] = []
        self.trouble = rng.choice((0.0, 0.02, 0.05, 0.1))  # share of ticks in which a process fails
        self.loss = rng.choice((0.0, 0.1, 0.3, 0.6))
        self.delay = rng.choice((0, 0, 1, 4, 15))  # ticks at most
        self.waits = rng.random() < 0.5  # whether the States of a tick are heard before its commands
        self.before: list[Vector] = list(self.world.truth.positions)
        self.operator = Random(f"operator {seed}") if self.scenario.obstacles else None
        self.network = Random(f"summaries {seed}") if self.scenario.hears_near else None
        self.tokens = Random(f"tokens {seed}")
        for robot in self.scenario.ids:
            if rng.random() < 0.15:
                self.world.give_up_waiting(robot)
            else:
                self._join(robot)

    def _drawn(self, seed: int, rng: Random) -> Scenario:
        return arena.drawn(seed, rng)

    # -- one tick

    def tick(self) -> None:
        world = self.world
        self._begin()
        awake = [each for each in (*self.processes.values(), *self.former) if each.asleep <= 0]
        self.rng.shuffle(awake)
        if self.waits:
            self._together(awake)
        else:
            self._each_by_itself(awake)
        self._deliver()
        for command in (*self.late, *self.late):
            world.accept(command)
        self.late = self.late[-20:]
        if self.network is not None:
            self._cut_off(self.tokens)
        world.close_tick()
        for process in self.processes.values():
            process.asleep -= 1

    def _begin(self) -> None:
        """Trouble comes first; then the world tells what it has to tell."""
        rng, world = self.rng, self.world
        for robot in self.scenario.ids:
            if rng.random() < self.trouble:
                self._trouble(robot)
        self._tell(world.open_tick())
        if not world.is_open:
            for robot in world.lives.awaited:
                world.give_up_waiting(robot)
            self._tell(world.open_tick())
        if self.network is not None:
            self._sum_up(self.network)
        self.before = list(world.truth.positions)
        if self.operator is not None and self.operator.random() < 0.2:
            self._operate(self.operator)

    def _tell(self, told: Mapping[int, Tick]) -> None:
        for robot, tick in told.items():
            process = self.processes.get(robot)
            if process is not None and self.rng.random() >= 0.3 * self.loss:
                process.queue.append(tick)

    def _cut_off(self, rng: Random) -> None:
        """A process that lives on may be taken for dead: what it commanded in this tick is void, and another
        is awaited in its place, which does not come."""
        if rng.random() < self.trouble:
            robot = rng.choice(self.scenario.ids)
            self.world.lost(robot)
            self.world.lives.expect(robot)

    def _sum_up(self, rng: Random) -> None:
        """Deliver the newest summary to each process, or lose it, at any time after it was made."""
        summary = self.world.exchange.summary
        places = None if summary is None else SummaryPlaces(summary)
        for process in (*self.processes.values(), *self.former):
            if places is not None and rng.random() >= self.loss:
                process.core.inbox.on_summary(places)

    def _operate(self, rng: Random) -> None:
        book = self.world.lives.obstacles
        here = [*book.standing, *book.appearing]
        if here and rng.random() < 0.3:
            self.world.operate(Operation(take=rng.choice(here)))
            return
        obstacle = arena.obstacle_beside(rng, rng.choice(self.before))
        if self.world.lives.founded and rng.random() < 0.3:
            self.world.lives.announce(
                obstacle.shape
            )  # the world refuses what is on a robot; the roster need not
        else:
            self.world.operate(Operation(place=obstacle))

    def _together(self, awake: list[_Process]) -> None:
        """All States are on their way before any robot commands."""
        for process in awake:
            self._open(process)
        self._deliver()
        for process in awake:
            self._command(process)

    def _each_by_itself(self, awake: list[_Process]) -> None:
        """No robot waits for another; one that wakes handles all Ticks that it has missed."""
        for process in awake:
            while process.queue:
                self._open(process)
                self._command(process)
            self._deliver()

    def violation(self) -> str:
        """What touched; "" if nothing did."""
        contacts = self.world.referee.record.totals.contacts
        return f"contact of {contacts[0].pair}, {-contacts[0].deepest:.3g} m deep" if contacts else ""

    # -- processes

    def _join(self, robot: int) -> None:
        """A new process for the robot; the former one may go on publishing."""
        if robot in self.processes:
            self.former.append(self.processes.pop(robot))
        self._live(_Process(), robot)

    def _live(self, process: _Process, robot: int) -> None:
        """The process begins a new incarnation of its robot."""
        core = self.product.Robot(self.scenario, robot, self.world.join(robot))
        core._law = Attack(self.rng, self.world, robot)
        process.core = core
        self.processes[robot] = process

    def _trouble(self, robot: int) -> None:
        process = self.processes.get(robot)
        if process is None:
            if self.rng.random() < 0.7:
                self._join(robot)
            return
        kind = self.rng.choice(("sleep", "sleep", "die", "restart"))
        if kind == "sleep":
            process.asleep = self.rng.randint(1, 12)
            return
        self.world.lost(robot)
        if kind == "die":
            self.former.append(self.processes.pop(robot))
        else:
            self._join(robot)

    def _open(self, process: _Process) -> None:
        """Handle Ticks up to the next that opens a tick, as `RobotNode` does."""
        process.opened = False
        while process.queue and not process.opened:
            tick = process.queue.popleft()
            core = process.core
            if core.has_ended(tick):
                if self.processes.get(core.robot) is process and self.world.lives.of[core.robot].fenced:
                    self._live(process, core.robot)
            elif tick.incarnation == core.incarnation and tick.tick > core.tick:
                process.state = core.begin(tick)
                process.opened = True
                self._publish(process.state)

    def _command(self, process: _Process) -> None:
        if not process.opened:
            return
        process.opened = False
        command = process.core.command()
        if self.rng.random() >= 0.3 * self.loss:
            self.world.accept(command)
        if self.rng.random() < 0.3:
            self.late.append(command)
        if process.state is not None and self.rng.random() < 0.2:
            self._publish(process.state)  # again

    def _publish(self, state: State) -> None:
        for robot in self.scenario.ids:
            if robot != state.robot and self.rng.random() >= self.loss:
                arrival = self.world.tick + self.rng.randint(0, self.delay)
                self.under_way.append((arrival, state, robot))

    def _deliver(self) -> None:
        """What has arrived is heard, in any order; some of it once more, later."""
        due = [each for each in self.under_way if each[0] <= self.world.tick]
        self.under_way = [each for each in self.under_way if each[0] > self.world.tick]
        self.rng.shuffle(due)
        for _, state, robot in due:
            radius = self.scenario.spec(state.robot).radius
            for process in self._all_of(robot):
                if process.core.epoch == state.epoch:
                    process.core.inbox.on_state(addressed_to(robot, state, radius))
            if self.rng.random() < 0.1:
                self.under_way.append((self.world.tick + self.rng.randint(1, 10), state, robot))

    def _all_of(self, robot: int) -> Iterator[_Process]:
        for process in (*self.processes.values(), *self.former):
            if process.core.robot == robot:
                yield process


class _Process:
    """What stands for a robot: its core, and what it has not handled yet."""

    def __init__(self) -> None:
        self.core: Any = None
        self.queue: deque[Tick] = deque()
        self.asleep = 0  # ticks
        self.opened = False
        self.state: State | None = None
