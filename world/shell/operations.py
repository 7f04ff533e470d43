"""Requests of operators while a fleet runs: goals, membership, obstacles, the emergency stop, the pace."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from protocol.bus.bus import Bus
from protocol.errors import MessageError
from protocol.keys import Address, robot_key
from protocol.operations import Outcome, Reply, decode_operation, decode_steer, encode_reply
from protocol.scenario.model import Operation
from world.shell.pacing import Pacing
from world.shell.publishers import Publishers
from world.shell.run import JudgedRun, Phase

UNNAMED = "a release names the number of stops so far, `release`: it lifts no later one"
OTHER_WORLD = "another world of this run is on the network: all robots stand until one of the two has left"


class Operations:
    """Answers operators, and keeps the emergency stop."""

    def __init__(
        self,
        bus: Bus,
        name: str,
        run: JudgedRun,
        publishers: Publishers,
        pacing: Pacing,
        *,
        warn: Callable[[str], None],
        info: Callable[[str], None],
    ) -> None:
        self._bus, self._name, self._run = bus, name, run
        self._publishers, self._pacing = publishers, pacing
        self._warn, self._info = warn, info
        self._rivals: set[str] = set()  # sessions of other worlds of this run

    def reply(self, address: Address, payload: bytes) -> bytes | None:
        """Execute an operator's request; returns the outcome, None for others. Raises MessageError."""
        if address.robot is not None or address.stream not in ("operation", "steering"):
            return None
        if address.stream == "steering":
            if self._pacing.lockstep:
                self._pacing.steering.apply(decode_steer(payload))
            return encode_reply(self._pacing.steering, payload)
        try:
            operation = decode_operation(payload)
            outcome = Outcome(True) if operation is None else self._operate(operation)
        except MessageError as error:
            self._run.rejected[error.reason] += 1
            outcome = Outcome(False, text=str(error))
        world = self._run.world
        state = Reply(
            **msgspec.structs.asdict(outcome),
            tick=world.tick,
            halted=world.halted,
            stops=world.stops,
            moving=world.moving,
            roster=world.lives.roster.message,
            obstacles=world.lives.obstacles.present,
            goals=world.goal_statuses(),
        )
        return encode_reply(state, payload)

    def _operate(self, operation: Operation) -> Outcome:
        world, asked = self._run.world, f"tick {self._run.world.tick}: {operation}"
        if operation.halt is False:
            return Outcome(False, text=UNNAMED)
        if operation.halt or operation.release is not None:
            if world.contested and not operation.halt:
                return Outcome(False, text=OTHER_WORLD)
            before, outcome = world.stopped, world.operate(operation)
            if world.stopped != before:
                self._warn(asked)
            return outcome
        over = self._run.phase is not Phase.RUNNING
        outcome = Outcome(False, text="the run is over") if over else world.operate(operation)
        if outcome.accepted and operation.add is not None:
            self._welcome(operation.add.id)
        self._info(asked + ("" if outcome.accepted else f": refused, {outcome.text}"))
        return outcome

    def _welcome(self, robot: int) -> None:
        """Declare subscriptions and publishers for another robot."""
        if robot not in self._publishers:
            self._bus.subscribe(robot_key(self._name, robot, "command"))
        self._publishers.add(robot)

    def on_world(self, session: str, alive: bool) -> None:
        """Another world of this run appeared or disappeared."""
        before = bool(self._rivals)
        (self._rivals.add if alive else self._rivals.discard)(session)
        if bool(self._rivals) != before:
            left = f"the other world has left; {'stays stopped' if self._run.world.stopped else 'goes on'}"
            what = OTHER_WORLD if alive else left
            self._warn(f"tick {self._run.world.tick}: {what}")
        self._run.world.contest(bool(self._rivals))
        self._publishers.watched(self._run.clock(), self._run.news())
