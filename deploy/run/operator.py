"""An operator of a running fleet: gives orders, and waits for what comes of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import msgspec

from protocol.bus.bus import Bus, Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.errors import BusError, MessageError
from protocol.keys import checked_run, robot_key, world_key
from protocol.messages import GoalStatus, Member, Thing
from protocol.process.log import LOG
from protocol.process.signals import STOP
from protocol.requests.fleet import FleetReply
from protocol.requests.form import read_reply
from protocol.requests.goals import GoalOrder, GoalReply
from protocol.requests.halt import Halt, Halted
from protocol.requests.things import ThingOrder, ThingReply
from protocol.scenario.model import RobotSpec

ANSWER = 5.0  # s within which a router is reached, and a world answers
_LOOK = 0.05  # s between looks at the roster


class Operator:
    """Speaks to the world of one run over a bus of its own.

    Args:
        bus: the process's own connection.
        run: name of the run.
        warn: is told if several worlds answer.
    """

    def __init__(self, bus: Bus, run: str, warn: Callable[[str], None] = LOG.warning) -> None:
        self._bus, self._run, self._warn, self._warned = bus, checked_run(run), warn, False

    def order(self, robot: int, order: GoalOrder) -> GoalReply:
        """Send a robot elsewhere.

        Raises:
            BusError: no world of this run answers.
            MessageError: what answers is of another version.
        """
        return self._ask(robot, msgspec.msgpack.encode(order))

    def status(self, robot: int) -> GoalReply:
        """How things stand with a robot's goal; raises as `order` does."""
        return self._ask(robot, b"")

    def add(self, spec: RobotSpec) -> FleetReply:
        """Have the disk of another robot appear; raises as `order` does."""
        return self._change({"add": spec})

    def remove(self, robot: int) -> FleetReply:
        """End a robot, and have its disk taken away; raises as `order` does."""
        return self._change({"remove": robot})

    def fleet(self) -> FleetReply:
        """Who is there; raises as `order` does."""
        return read_reply(self._answer(world_key(self._run, "fleet"), b""), FleetReply, "fleet")

    def appeared(self, robot: int, within: float) -> Member:
        """Wait until the disk of a robot that was added is in its place.

        Raises:
            BusError: it is not, `within` s later: somebody cannot get out of its way.
        """
        deadline = time.monotonic() + within
        while True:
            member = next((each for each in self.fleet().roster.members if each.robot == robot), None)
            if member is not None and member.status in ("standing", "live"):
                return member
            if time.monotonic() >= deadline:
                raise BusError(
                    f"robot {robot} has not appeared within {within:g} s: somebody is in its place"
                )
            STOP.check()
            self._bus.receive(_LOOK)

    def place(self, thing: ThingOrder) -> ThingReply:
        """Have a thing appear; raises as `order` does."""
        return self._surround(msgspec.msgpack.encode({"place": thing}))

    def take(self, number: int) -> ThingReply:
        """A thing was taken away; raises as `order` does."""
        return self._surround(msgspec.msgpack.encode({"take": number}))

    def things(self) -> ThingReply:
        """What stands and is no robot; raises as `order` does."""
        return self._surround(b"")

    def stands(self, number: int, within: float) -> Thing:
        """Wait until a thing that was accepted stands in its place.

        Raises:
            BusError: it does not, `within` s later: somebody cannot get out of its way.
        """
        deadline = time.monotonic() + within
        while True:
            thing = next((each for each in self.things().things if each.number == number), None)
            if thing is not None and thing.status == "standing":
                return thing
            if thing is None or time.monotonic() >= deadline:
                why = "was taken away" if thing is None else "has not appeared: somebody is in its place"
                raise BusError(f"thing {number} {why}")
            STOP.check()
            self._bus.receive(_LOOK)

    def _surround(self, request: bytes) -> ThingReply:
        return read_reply(self._answer(world_key(self._run, "things"), request), ThingReply, "things")

    def _change(self, change: dict[str, object]) -> FleetReply:
        return read_reply(
            self._answer(world_key(self._run, "fleet"), msgspec.msgpack.encode(change)), FleetReply, "fleet"
        )

    def stop(self, within: float) -> Halted:
        """Have all robots stand: asks again until every world that answers says that they do.

        Returns the last answer; `moving` names the robots that do not stand `within` s later.

        Raises:
            BusError: no world of this run answers.
            MessageError: what answers is of another version.
        """
        deadline = time.monotonic() + within
        while True:
            told = self.halt(True)
            if (told.halted and not told.moving) or time.monotonic() >= deadline:
                return told
            self._bus.receive(_LOOK)

    def halt(self, halt: bool | None = None) -> Halted:
        """Have all robots stand, release them, or (None) ask for the state; raises as `stop` does.

        Of several worlds: whether all are halted, the newest tick, and the robots that move in any.
        """
        request = b"" if halt is None else msgspec.msgpack.encode(Halt(halt))
        replies = self._answers(world_key(self._run, "halt"), request)
        told = [read_reply(reply, Halted, "halt") for reply in replies]
        moving = {robot for each in told for robot in each.moving}
        return Halted(
            all(each.halted for each in told),
            max(each.tick for each in told),
            tuple(sorted(moving)),
            next((each.text for each in told if each.text), ""),
        )

    def outcome(self, robot: int, number: int, within: float) -> GoalStatus:
        """What came of an order: waits until it is arrived, cancelled, given up, or followed by another.

        Raises:
            BusError: nothing did, for `within` s.
        """
        self._bus.subscribe(robot_key(self._run, robot, "goalstatus"))
        deadline = time.monotonic() + within
        status = self.status(robot).status  # it may have come before the subscription
        while status is None or (status.number == number and status.status == "under way"):
            STOP.check()
            event = self._bus.receive(max(0.0, deadline - time.monotonic()))
            if isinstance(event, Sample):
                try:
                    heard = decode(event.key, event.payload)
                except MessageError:
                    continue  # a stranger's; the world's own word comes
                status = heard if isinstance(heard, GoalStatus) else status
            elif time.monotonic() >= deadline:
                raise BusError(f"robot {robot} has not come to an end of order {number} in {within:g} s")
        return status

    def _ask(self, robot: int, payload: bytes) -> GoalReply:
        return read_reply(self._answer(robot_key(self._run, robot, "goal"), payload), GoalReply, "goal")

    def _answer(self, key: str, request: bytes) -> bytes:
        return self._answers(key, request)[0]

    def _answers(self, key: str, request: bytes) -> list[bytes]:
        try:
            replies = self._bus.ask(key, request, ANSWER)
        except BusError as error:
            raise BusError(f"no world of run {self._run!r} answers: {error}") from error
        if len(replies) > 1 and not self._warned:
            self._warned = True
            self._warn(f"{len(replies)} worlds of run {self._run!r} were asked, and answer: end all but one")
        return replies


@contextmanager
def operating(connection: Connection, run: str) -> Iterator[Operator]:
    """An operator with a session of its own; a fleet that is not there yet is not waited for.

    Raises:
        BusError: nobody listens where `connection` leads.
    """
    bus = ZenohBus(replace(connection, timeout=ANSWER))
    try:
        yield Operator(bus, run)
    finally:
        bus.close()
