"""What operators ask for while a fleet runs: goals, who and what is there, the emergency stop, the pace."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from protocol.bus.bus import Bus
from protocol.errors import MessageError
from protocol.keys import Address, robot_key
from protocol.requests.fleet import FleetReply, decode_change
from protocol.requests.form import encode_reply
from protocol.requests.goals import GoalReply, decode_order
from protocol.requests.halt import Halted, decode_halt
from protocol.requests.steering import decode_steer
from protocol.requests.things import ThingReply, decode_thing_change
from world.coordinator.surroundings import present
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.shell.publishers import Publishers
from world.shell.run import Phase, Run

OTHER_WORLD = "another world of this run is on the network: all robots stand until one of the two has left"


class Operations:
    """Answers operators, and keeps the emergency stop.

    Args:
        bus: where another robot is heard.
        run: its name.
        several: whether this world judges several scenarios, each of which says who is in it.
        admissions, publishers, pacing: of the world.
        say: takes what a person should know.
        note: takes what is worth a line in a log.
    """

    def __init__(
        self,
        bus: Bus,
        run: str,
        several: bool,
        admissions: Admissions,
        publishers: Publishers,
        pacing: Pacing,
        *,
        say: Callable[[str], None],
        note: Callable[[str], None],
    ) -> None:
        self._bus, self._name, self._several = bus, run, several
        self._admissions, self._publishers, self._pacing = admissions, publishers, pacing
        self._say, self._note = say, note
        self._rivals: set[str] = set()  # sessions of other worlds of this run
        self._handlers = {
            "goal": self._order,
            "fleet": self._change,
            "things": self._surround,
            "halt": self._halt,
            "steering": self._steer,
        }

    def answers(self, address: Address) -> bool:
        """Whether a question is an operator's."""
        return address.stream in self._handlers and (address.robot is not None) == (address.stream == "goal")

    def reply(self, address: Address, payload: bytes, run: Run) -> bytes:
        """Do what is asked, and say what came of it.

        Raises:
            MessageError: the payload is no such question.
        """
        return self._handlers[address.stream](address, payload, run)

    def _order(self, address: Address, payload: bytes, run: Run) -> bytes:
        """An order of where to go, or the question how things stand."""
        robot = address.robot
        assert robot is not None
        try:
            order = decode_order(payload)
        except MessageError as error:
            run.rejected[error.reason] += 1
            return encode_reply(GoalReply(False, text=str(error)), payload)
        status = run.world.goal_status(robot)
        if order is None:
            known = GoalReply(status is not None, text="" if status else f"no robot {robot}", status=status)
            return encode_reply(known, payload)
        if run.phase is not Phase.RUNNING:
            return encode_reply(GoalReply(False, text="the run is over", status=status), payload)
        reply = run.world.order(robot, order)
        self._publishers.goals(run.world.goal_news())
        self._log(run, f"robot {robot} is sent to {list(order.points)}", reply.text)
        return encode_reply(reply, payload)

    def _change(self, _: Address, payload: bytes, run: Run) -> bytes:
        """A robot is to come or to go, or the question who is there."""
        world, text, change = run.world, "", None
        try:
            change = decode_change(payload)
        except MessageError as error:
            run.rejected[error.reason] += 1
            text = str(error)
        if change is not None and self._several:
            text = "this world judges several scenarios one after another: each says who is in it"
        elif change is not None and change.add is not None:
            text = world.add(change.add)
            if not text:
                self._welcome(change.add.id)
        elif change is not None and change.remove is not None:
            text = world.remove(change.remove)
        if change is not None:
            self._log(run, str(change), text)
        return encode_reply(FleetReply(not text, world.coordinator.lives.roster, text), payload)

    def _log(self, run: Run, asked: str, refusal: str) -> None:
        """Note what was asked for, and what came of it."""
        self._note(f"tick {run.world.tick}: {asked}" + (f": refused, {refusal}" if refusal else ""))

    def _welcome(self, robot: int) -> None:
        """Have what is needed to hear and tell another robot."""
        if robot not in self._publishers:
            self._bus.subscribe(robot_key(self._name, robot, "command"))
        self._publishers.add(robot)

    def _surround(self, _: Address, payload: bytes, run: Run) -> bytes:
        """A thing is to come, or has gone, or the question what is there."""
        world, reply = run.world, ThingReply(True)
        change = decode_thing_change(payload)
        if change is not None and run.phase is not Phase.RUNNING:
            reply = ThingReply(False, text="the run is over")
        elif change is not None and change.place is not None:
            reply = world.add_thing(change.place)
        elif change is not None and change.take is not None:
            reply = world.remove_thing(change.take)
        if change is not None:
            self._log(run, str(change), reply.text)
        things = present(world.scenario.shapes, world.coordinator.lives.things.changes)
        return encode_reply(msgspec.structs.replace(reply, things=things), payload)

    def _halt(self, _: Address, payload: bytes, run: Run) -> bytes:
        """The emergency stop, its release, or the question whether it is in force."""
        asked = decode_halt(payload)
        if asked is not None:
            if asked.halt != run.world.coordinator.stopped:
                self._say(f"tick {run.world.tick}: {'emergency stop' if asked.halt else 'released'}")
            run.world.halt(asked.halt)
            self._publishers.watched(run.clock(), run.world.news())
        world, coordinator = run.world, run.world.coordinator
        text = OTHER_WORLD if coordinator.contested and not coordinator.stopped else ""
        return encode_reply(Halted(coordinator.halted, world.tick, world.moving, text), payload)

    def on_world(self, session: str, alive: bool, run: Run) -> None:
        """Another world of this run is on the network, or has left it."""
        before = bool(self._rivals)
        (self._rivals.add if alive else self._rivals.discard)(session)
        if bool(self._rivals) != before:
            self._say(
                f"tick {run.world.tick}: {OTHER_WORLD if alive else 'the other world has left; goes on'}"
            )
        self.begin(run)
        self._publishers.watched(run.clock(), run.world.news())

    def begin(self, run: Run) -> None:
        """Have the robots of a run stand if there is another world."""
        run.world.contest(bool(self._rivals))

    def _steer(self, _: Address, payload: bytes, __: Run) -> bytes:
        """Slow motion, where ticks wait for the robots."""
        steer = decode_steer(payload)
        if self._pacing.lockstep:
            self._pacing.steering.apply(steer)
        return msgspec.msgpack.encode(self._pacing.steering)
