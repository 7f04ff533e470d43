"""The world: true positions, what each robot is told of them, what its commands do, and the judge.

Sans-I/O: no clock, no socket; the caller says when robots joined, went, and when a tick is over.
One tick: `open_tick` (and `join` for whoever is awaited), `accept` commands, `close_tick`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from protocol.messages import Command, Down, Measurement, Truth, Vector
from protocol.scenario import Scenario
from world.clearance import Disks, Plane, gaps
from world.contacts import Contacts
from world.kinematics import STANDING, Actuation
from world.lives import Lives
from world.phi import NavigationFunction
from world.report import Ledger, report
from world.sensing import Sensor
from world.trajectory import TrajectoryDigest
from world.verdict import Judge


class World:
    """One run of a scenario.

    Attributes:
        tick: the tick that is open, or that is to be opened next.
        truth: where every disk is at the start of `tick`.
        active: ids that take part in the tick opened last.
        verdict, reason: empty while the run goes on.
    """

    def __init__(self, scenario: Scenario, incarnations: Mapping[int, int] | None = None) -> None:
        """Args:
        scenario: with the gain k a number.
        incarnations: last known incarnation by robot id, of earlier runs; 0 if absent.
        """
        self.tick = 0
        self.active: tuple[int, ...] = ()
        self.verdict = ""
        self.reason = ""
        self._scenario = scenario
        self._disks = Disks(scenario)
        self._ids = self._disks.ids
        self._index = {robot: index for index, robot in enumerate(self._ids)}
        self._positions: list[Vector] = [scenario.spec(robot).start for robot in self._ids]
        self._displacements: list[Vector] = [STANDING] * len(self._ids)
        self._sensors = {robot: Sensor(scenario, robot) for robot in self._ids}
        self._lives = Lives(scenario, incarnations or {})
        self._actuation = Actuation(scenario)
        self._phi = NavigationFunction(scenario, self._disks)
        self._contacts = Contacts(self._disks)
        self._judge = Judge(scenario, self._ids)
        self._digest = TrajectoryDigest(self._ids)
        self._ledger = Ledger(len(self._ids))
        self._measurements: dict[int, Measurement] | None = None
        self._members = 0
        self._waiting: set[int] = set()
        self._commands: dict[int, Vector] = {}
        self._plane = self._as_plane()
        self.truth = self._look(self._plane)

    @property
    def incarnations(self) -> dict[int, int]:
        """Newest incarnation of every robot; a following run counts on from there."""
        return {robot: life.incarnation for robot, life in self._lives.of.items()}

    @property
    def down(self) -> tuple[Down, ...]:
        """Fenced lives: fixed disks until that robot joins again."""
        return self._lives.down

    @property
    def awaiting_join(self) -> frozenset[int]:
        """Robots that must be up at this tick, by the scenario, and have not joined."""
        return self._lives.awaited

    @property
    def waiting(self) -> frozenset[int]:
        """Active robots whose command of the open tick is outstanding."""
        return frozenset(self._waiting)

    def join(self, robot: int) -> int:
        """A process takes over a robot; it takes part from the next opening of a tick on.

        Returns its incarnation.

        Raises:
            JoinError: unknown id, or an id that is running or held down by the scenario.
        """
        heard = self.tick - 1 if self._measurements is None else self.tick
        return self._lives.join(robot, heard)

    def lost(self, robot: int) -> None:
        """The robot's process is gone or given up on: it stands still and takes no part from now on."""
        self._lives.lose(robot)
        self.active = tuple(other for other in self.active if other != robot)
        self._waiting.discard(robot)
        self._commands.pop(robot, None)

    def give_up_waiting(self, robot: int) -> None:
        """Go on without a robot of `awaiting_join`; it may still join later."""
        self._lives.give_up(robot)

    def open_tick(self) -> dict[int, Measurement]:
        """Begin the tick: what each robot that may listen is to be told. Idempotent until `close_tick`.

        The scenario's process faults of this tick happen first. While robots are awaited the tick does
        not begin: only those of them that have to learn that they were fenced are told.
        """
        if self._measurements is None:
            self._lives.apply_faults(self.tick)
            awaited = self.awaiting_join
            if awaited:
                return {robot: told for robot, told in self._tell(self._lives.up).items() if robot in awaited}
            self._begin()
        return self._measurements or {}

    def _begin(self) -> None:
        self.active = self._lives.up
        self._members = len(self.active)
        self._waiting = set(self.active)
        sensed = {
            robot: sensor.measure(self.tick, position)
            for (robot, sensor), position in zip(self._sensors.items(), self._positions, strict=True)
        }
        self._measurements = self._tell(self.active, sensed)

    def _tell(
        self, active: tuple[int, ...], sensed: Mapping[int, tuple[Vector | None, int]] | None = None
    ) -> dict[int, Measurement]:
        """Measurements for all that may listen; without positions unless `sensed` has them."""
        tick, down, index = self.tick, self.down, self._index
        told = {}
        for robot, life in self._lives.listeners():
            position, stamp = sensed[robot] if sensed else (None, tick)
            moved = self._displacements[index[robot]]
            told[robot] = Measurement(robot, life.incarnation, tick, position, stamp, moved, active, down)
        return told

    def accept(self, command: Command) -> bool:
        """Take a command if it is of the open tick, of an active life and the first; else count why not."""
        reason = self._refusal(command)
        if reason:
            self._ledger.refused[reason] += 1
            return False
        self._waiting.discard(command.robot)
        self._commands[command.robot] = command.velocity
        self._lives.of[command.robot].heard = self.tick
        return True

    def _refusal(self, command: Command) -> str:
        """Why a command is not executed; empty if it is."""
        if command.robot in self._waiting:
            life = self._lives.of[command.robot]
            if command.incarnation == life.incarnation and command.tick == self.tick:
                return ""
        known = self._lives.of.get(command.robot)
        if known is None:
            return "unknown"
        if command.incarnation != known.incarnation:
            return "incarnation"
        if known.down is not None:
            return "fenced"
        if command.tick != self.tick or self._measurements is None:
            return "late" if command.tick < self.tick else "early"
        return "duplicate" if command.robot in self._commands else "inactive"

    def close_tick(self) -> Truth:
        """End the tick: move everything, judge, advance. Missing commands mean standing still."""
        if self._measurements is None:
            raise RuntimeError(f"tick {self.tick} is not open: call open_tick, and join for those awaited")
        self._ledger.missed += self._members - len(self._commands)
        self._move()
        before, self._plane = self._plane, self._as_plane()
        during = gaps(self._disks, before, self._plane)
        self._contacts.add(self.tick, during, before, self._plane)
        for robot in self._ids:
            if robot not in self._commands:
                self._lives.fence(self.tick, robot, self._positions[self._index[robot]])
        self._commands, self._waiting, self._measurements = {}, set(), None
        self.tick += 1
        self.truth = self._look(self._plane, float(during.min()))
        self._decide()
        return self.truth

    def _move(self) -> None:
        """All move: x += executed velocity times step."""
        for index, robot in enumerate(self._ids):
            velocity = self._commands.get(robot)
            if velocity is None:
                self._displacements[index] = STANDING
                continue
            dx, dy = self._actuation.displacement(velocity, robot, self.tick)
            x, y = self._positions[index]
            self._positions[index] = (x + dx, y + dy)
            self._displacements[index] = (dx, dy)
            self._ledger.walked(index, dx, dy)

    def _look(self, plane: Plane, clearance: float | None = None) -> Truth:
        """The truth at the start of `tick`; it goes into the digest and the measures."""
        if clearance is None:
            clearance = float(gaps(self._disks, plane, plane).min())
        phi = self._phi(plane)
        self._digest.add(self.tick, self._positions)
        self._ledger.note(clearance, phi)
        return Truth(self.tick, self._ids, tuple(self._positions), clearance, phi)

    def _as_plane(self) -> Plane:
        return np.array([complex(x, y) for x, y in self._positions])

    def _decide(self) -> None:
        if not self.verdict:
            up = self._lives.up
            alone = len(up) < len(self._ids) and self._lives.gone_for_good(self.tick - 1)
            verdict, reason = self._judge.judge(self.tick, self._plane, up, alone)
            if verdict:
                self.finish(verdict, reason)

    def finish(self, verdict: str, reason: str) -> None:
        """End the run, e.g. as interrupted or aborted; a collision outranks, a second verdict is ignored."""
        if self.verdict:
            return
        touches = len(self._contacts.all)
        if touches:
            verdict, reason = "collision", f"{touches} contacts; else {verdict}: {reason}"
        self.verdict, self.reason = verdict, reason

    def report(self) -> dict[str, Any]:
        """All that the world knows of the result, in plain types that JSON knows."""
        return report(
            self._scenario,
            verdict=(self.verdict, self.reason),
            arrived=self._judge.arrived(self._plane),
            truth=self.truth,
            ledger=self._ledger,
            contacts=self._contacts.all,
            lives=self._lives,
            sensors=self._sensors.values(),
            digest=self._digest.hexdigest(),
        )
