"""The messages of one tick: a Tick to each robot that may listen, and a Command from each active robot.

When a lock-step tick does not end, it is repeated, and a robot that cannot command lists the States that it
lacks. Then robots are given up as follows, so that one faulty process costs one robot:

1. a robot that owes a Command and is silent: it hangs, though its session is alive;
2. one whose State more than half of its receivers lack: it sends none, or one that all refuse;
3. otherwise, one that cannot command: it does not receive what the others receive.

Half of all receivers, not of the waiting ones: one deaf robot must not exclude all others. In a large fleet a
robot receives the States of the robots that it is bound to, and a summary of all positions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping

import msgspec
import numpy as np

from protocol.crowd import LEAD, period
from protocol.messages import Command, Sense, Summary, Tick, Vector
from protocol.scenario.model import Scenario
from world.coordinator.lives import Lives
from world.coordinator.missions import Missions


class Interest:
    """Interest management of a run in which robots receive the States of the peers in their bindings."""

    def __init__(self, scenario: Scenario) -> None:
        self.summary: Summary | None = None  # the newest to publish; None before the first
        self.places: dict[int, Vector] = {spec.id: spec.start for spec in scenario.robots}  # m, last measured
        self._period = period(scenario)
        self._slices: dict[int, float] = {}  # m, of the newest Command
        # By robot: its life, and the first tick in which it receives each peer's State.
        self._since: dict[int, tuple[int, dict[int, int]]] = {}

    def open(
        self,
        tick: int,
        scenario: Scenario,
        sensed: Mapping[int, Sense],
        goal: Callable[[int], Vector | None],
    ) -> None:
        """Begin a tick, with the measurement of every robot, and its goal (m) unless it is the scenario's."""
        for robot, sense in sensed.items():
            if sense.position is not None:
                self.places[robot] = sense.position
        if tick % self._period == 0:
            ids = scenario.ids
            starts = {spec.id: spec.start for spec in scenario.robots}
            places = np.array([self.places.get(robot, starts[robot]) for robot in ids], dtype=np.float64)
            goals = {spec.id: goal(spec.id) or spec.goal for spec in scenario.robots}
            offsets = places - np.array([goals[robot] for robot in ids], dtype=np.float64)
            gammas = (offsets**2).sum(axis=1)
            known = np.array([self._slices.get(robot, np.nan) for robot in ids])
            # Of a robot that has published no slice, that of the attraction alone.
            slices = np.where(np.isnan(known), 2.0 * np.sqrt(gammas), known)
            where, far, pace = (each.astype("<f4").tobytes() for each in (places, gammas, slices))
            self.summary = Summary(tick, runs(ids), where, far, pace)

    def accept(self, command: Command) -> None:
        """Note an accepted command."""
        if command.slice is not None:
            self._slices[command.robot] = command.slice

    def heard(
        self, robot: int, incarnation: int, tick: int, bound: Iterable[int], active: frozenset[int]
    ) -> tuple[int, ...]:
        """The active robots whose States a life receives in this tick, itself included, from the peers that
        it is `bound` to: it is subscribed to a peer LEAD ticks after the Tick that named it.
        """
        life, before = self._since.get(robot, (0, {}))
        if life != incarnation:
            before = {}
        since = {peer: before.get(peer, tick + LEAD) for peer in bound}
        self._since[robot] = incarnation, since
        heard = (peer for peer, begun in since.items() if begun <= tick and peer in active)
        return tuple(sorted([robot, *heard]))


def runs(ids: Iterable[int]) -> bytes:
    """Ascending ids as a Summary encodes them: the first of each run of consecutive ids, and its length."""
    found: list[list[int]] = []
    for each in ids:
        if found and each == sum(found[-1]):
            found[-1][1] += 1
        else:
            found.append([each, 1])
    return np.array(found, dtype="<u4").tobytes()


class Exchange:
    """Ticks and Commands. One Command is accepted for the open tick, from an active life; a late one is still
    a sign of life of a robot that executes its own Commands. `tick` is opened first.
    """

    def __init__(self, scenario: Scenario, lives: Lives, missions: Missions, tick: int = 0) -> None:
        self.tick = tick  # the open tick, or the next one
        self.active: tuple[int, ...] = ()  # ids of the robots in the tick opened last
        self.ticks: dict[int, Tick] | None = None  # by robot that may listen; None while no tick is open
        self.taken: dict[int, Command] = {}  # in this tick, by robot
        self.waiting: set[int] = set()  # active robots that still owe a Command
        self.missed = 0  # Commands, over all active robots and ticks
        # Commands refused, by reason: late, early, incarnation (of another life), fenced, inactive,
        # duplicate, unknown, ledger (it refers to a roster or grants that were never made).
        self.refused = Counter[str]()
        self._missing: dict[int, tuple[int, ...]] = {}  # ids of missing States, by the robot that lacks them
        self._lives, self._missions, self._is_external = lives, missions, scenario.is_external
        self._interest = Interest(scenario) if scenario.hears_near else None

    @property
    def summary(self) -> Summary | None:
        """Positions of all robots, if one is due in this tick."""
        return None if self._interest is None else self._interest.summary

    def open(self, scenario: Scenario, sensed: Mapping[int, Sense], halted: bool) -> dict[int, Tick]:
        """Begin the tick, with measurement and odometry of every robot of the scenario; returns `ticks`."""
        self.active = self._lives.up
        self.taken, self._missing, self.waiting = {}, {}, set(self.active)
        interest, keeper = self._interest, self._lives.keeper
        if interest is None:
            keeper.advance({})
            self.ticks = self._build_ticks(dict.fromkeys(self._lives.of, self.active), sensed, halted)
            return self.ticks
        interest.open(self.tick, scenario, sensed, self._missions.goal)
        keeper.advance(interest.places)
        present = frozenset(self.active)
        heard = {
            # A life that has not begun has no grants, and its ledger entry is still that of the life before.
            robot: interest.heard(
                robot, life.incarnation, self.tick, keeper.bound(robot) if life.begun else (), present
            )
            for robot, life in self._lives.listeners()
        }
        self.ticks = self._build_ticks(heard, sensed, halted)
        return self.ticks

    def fenced(self, halted: bool) -> dict[int, Tick]:
        """Ticks that inform robots of their fencing while the run waits. They bypass `Interest`, whose state
        must not depend on how often these are sent. A live incarnation receives nothing before the tick
        opens: its last Command is not settled yet."""
        lives = self._lives
        ticks = self._build_ticks(dict.fromkeys(lives.of, lives.up), {}, halted)
        return {robot: tick for robot, tick in ticks.items() if lives.of[robot].fenced}

    def _build_ticks(
        self, heard: Mapping[int, tuple[int, ...]], sensed: Mapping[int, Sense], halted: bool
    ) -> dict[int, Tick]:
        """Ticks for all that may listen, each with the active robots whose States it receives."""
        lives, goal, since = self._lives, self._missions.goal, self._missions.since
        return {
            robot: Tick(
                robot,
                life.incarnation,
                self.tick,
                heard[robot],
                sense=sensed.get(robot),
                roster=lives.roster.news(robot),
                goal=goal(robot) if life.is_new or life.heard < since(robot) else None,
                halted=halted,
                heard=life.heard if self._is_external and life.heard >= 0 else None,
                grants=lives.keeper.news(robot) if life.begun else None,
            )
            for robot, life in lives.listeners()
        }

    def close(self) -> None:
        """End the tick; outstanding commands are missed."""
        self.missed += len(self.waiting)
        self.waiting, self.ticks = set(), None
        self.tick += 1

    def drop(self, robot: int) -> None:
        """Remove a robot from the open tick with its Command; `ticks` informs the others."""
        if robot not in self.active:
            return
        self.active = tuple(other for other in self.active if other != robot)
        if self.ticks is not None:
            self.missed += 1
            self.waiting.discard(robot)
            self.taken.pop(robot, None)
            self.ticks = {other: _without(robot, tick) for other, tick in self.ticks.items()}

    def accept(self, command: Command) -> bool:
        """Accept a command, or count its refusal; a robot that cannot command lists missing States."""
        reason = self._refusal(command)
        if reason:
            self.refused[reason] += 1
            return reason == "late" and self._is_external and self._lives.on_command(command)
        if command.awaits:
            self._missing[command.robot] = command.awaits
            return False
        self.waiting.discard(command.robot)
        self.taken[command.robot] = command
        self._lives.on_command(command)
        if self._interest is not None:
            self._interest.accept(command)
        return True

    def _refusal(self, command: Command) -> str:
        life = self._lives.of.get(command.robot)
        if life is None:
            return "unknown"
        if command.incarnation != life.incarnation:
            return "incarnation"
        if life.fenced or self._lives.refuses(command):
            return "fenced" if life.fenced else "ledger"
        if command.tick != self.tick or self.ticks is None:
            return "late" if command.tick < self.tick else "early"
        if command.robot not in self.waiting:
            return "duplicate" if command.robot in self.taken else "inactive"
        return ""

    def blamed(self) -> dict[int, str]:
        """Robots to give up in the open tick, with reasons; clears the reports of missing States."""
        missing, self._missing = self._missing, {}
        ticks = self.ticks or {}
        heard_by = Counter(peer for robot in self.active for peer in ticks[robot].active)
        return blamed(heard_by, self.waiting, missing)


def _without(robot: int, tick: Tick) -> Tick:
    return msgspec.structs.replace(tick, active=tuple([each for each in tick.active if each != robot]))


def blamed(
    heard_by: Mapping[int, int], waiting: Collection[int], missing: Mapping[int, Collection[int]]
) -> dict[int, str]:
    """Robots to exclude, with reasons, in a repeated tick; at least one, if a command is outstanding.

    Args:
        heard_by: number of receivers of each active robot's State, itself included.
        waiting: those of them that owe a command.
        missing: ids of the States that each of these lacks, by its reports since the repetition.
    """
    silent = {robot: "hangs: it does not answer" for robot in sorted(waiting) if not missing.get(robot)}
    lack = Counter(peer for robot in waiting for peer in set(missing.get(robot, ())) if peer in heard_by)
    unheard = {
        robot: f"sends no State that its peers accept: {count} of {heard_by[robot] - 1} lack it"
        for robot, count in sorted(lack.items())
        if 2 * count > heard_by[robot] - 1
    }
    return (unheard | silent) or {
        robot: f"lacks the State of {_names(missing[robot])}" for robot in sorted(waiting)
    }


def _names(robots: Collection[int]) -> str:
    shown = sorted(robots)[:3]
    more = len(robots) - len(shown)
    return f"robot {', '.join(map(str, shown))}" + (f" and {more} more" if more else "")
