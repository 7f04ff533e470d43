"""Operations on a running fleet, with waiting for their outcome; and probes of processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from functools import cached_property
from math import inf
from pathlib import Path
from typing import cast

import msgspec

from deploy.security.membership import KeyRing
from deploy.security.roster import OPERATOR, ROUTER, WORLD
from protocol.bus.bus import Bus, Publish, Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode, encode
from protocol.errors import BusError, MessageError, UnservedError, UsageError
from protocol.keys import STREAMS, checked_run, robot_key, world_key, world_tokens
from protocol.messages import GoalStatus, Result, Vector, Wish
from protocol.operations import Reply, decode_reply
from protocol.process.log import LOG
from protocol.process.signals import STOP
from protocol.scenario.model import Operation

ANSWER = 5.0  # s for a router to accept, and for a world to answer
_SOON = 2.0  # s to wait for an answer before a warning that there is none, if the request is repeated
_PRESENT = 2.0  # s from a release to the number of stops in force; after that others may have followed
_LOOK = 0.05  # s between queries of the state
_PAUSE = 0.5  # s between them while nothing is published about an order
_AWAY = 60.0  # s in which a world that has answered may be restarted


class Operator:
    """Client of the world of one run, on a connection of its own; calls `warn` if several worlds answer."""

    def __init__(self, bus: Bus, run: str, warn: Callable[[str], None] = LOG.warning) -> None:
        self._bus, self._run, self._warn, self._warned = bus, checked_run(run), warn, False
        self._heard = inf  # s, monotonic: newest answer
        self._wishes: dict[int, Publish] = {}  # publishers, by robot

    def operate(self, operation: Operation | None = None, within: float = ANSWER) -> Reply:
        """Request an operation, or (None) the state alone; waits `within` s for an answer.

        If several worlds answer, their replies are combined: a refusal if one refuses, the newest tick,
        halted if all are, and all robots that move. A release asks for the number of stops so far, and lifts
        those: later ones remain, however late it arrives.

        Raises BusError without an answer (the operation may take effect all the same), or if that number was
        late; MessageError if the answer is of another version.
        """
        if operation is not None and operation.halt is False:
            operation = Operation(release=self._in_force())
        request = b"" if operation is None else msgspec.msgpack.encode(operation)
        once = operation is not None and not operation.halt  # a stop may be obeyed twice
        try:
            answers = self._bus.ask(world_key(self._run, "operation"), request, within, once=once)
        except BusError as error:
            sent = operation is not None and not isinstance(error, UnservedError)
            late = f" (It may still take effect: see `disknav monitor {self._run}`.)" if sent else ""
            raise BusError(f"no world of run {self._run!r} answers{self._others}: {error}{late}") from error
        self._heard = time.monotonic()
        if len(answers) > 1 and not self._warned:
            self._warned = True
            self._warn(f"{len(answers)} worlds of run {self._run!r} answer: end all but one")
        replies = [decode_reply(answer, Reply) for answer in answers]
        return msgspec.structs.replace(
            min(replies, key=lambda reply: reply.accepted),
            tick=max(reply.tick for reply in replies),
            halted=all(reply.halted for reply in replies),
            stops=min(reply.stops for reply in replies),
            moving=tuple(sorted({robot for reply in replies for robot in reply.moving})),
        )

    @cached_property
    def _others(self) -> str:
        """As `_other_runs`, looked up once, as it delays the next request."""
        return _other_runs(self._bus, self._run)

    def _in_force(self) -> int:
        """Number of stops so far; BusError if the answer is late: later stops may be among them."""
        asked = time.monotonic()
        stops = self.operate().stops
        if time.monotonic() > asked + _PRESENT:
            raise BusError(
                f"the world of run {self._run!r} answered after more than {_PRESENT:g} s: the robots are not "
                f"released, as they may have been stopped again meanwhile; release them again"
            )
        return stops

    def wish(self, robot: int, velocity: Vector) -> None:
        """Send the desired velocity, m/s, of a robot with law "external"; valid until the next one."""
        if robot not in self._wishes:
            self._wishes[robot] = self._bus.publisher(STREAMS["wish"], robot_key(self._run, robot, "wish"))
        self._wishes[robot](encode(Wish(robot, velocity)))

    def wait_for_begin(self, within: float) -> None:
        """Wait until the first tick of this run is over, at most `within` s; BusError without a world."""
        self._repeat(None, lambda reply: reply.tick > 0, within)

    def appeared(self, robot: int, within: float) -> str:
        """Wait until the disk of an added robot is present; returns its status.
        Raises BusError if another robot still occupies its place after `within` s, or it was removed.
        """

        def status(reply: Reply) -> str:
            return next((each.status for each in reply.roster.members if each.robot == robot), "gone")

        return self._awaited(status, within, f"robot {robot}")

    def stands(self, number: int, within: float) -> None:
        """Wait until an accepted obstacle is present.
        Raises BusError if a robot still occupies its place after `within` s, or the obstacle was removed.
        """

        def status(reply: Reply) -> str:
            return next((each.status for each in reply.obstacles if each.number == number), "gone")

        self._awaited(status, within, f"obstacle {number}")

    def _awaited(self, status: Callable[[Reply], str], within: float, what: str) -> str:
        """Query the status of a disk until it is present, at most `within` s."""
        try:
            found = status(self._repeat(None, lambda reply: status(reply) != "appearing", within))
        except BusError as error:
            raise BusError(f"{what} was accepted, but has not appeared: {error}") from error
        if found in ("appearing", "gone"):
            why = "it was removed" if found == "gone" else f"a robot occupies its place after {within:g} s"
            raise BusError(f"{what} was accepted, but has not appeared: {why}")
        return found

    def stop(self, within: float) -> Reply:
        """Stop all robots: repeats the request until every world confirms that they stand.

        Returns the last reply; its `moving` lists the robots that do not stand after `within` s. Raises as
        `operate`.
        """
        return self._repeat(Operation(halt=True), lambda reply: reply.halted and not reply.moving, within)

    def _repeat(self, operation: Operation | None, done: Callable[[Reply], bool], within: float) -> Reply:
        """Repeat a request until its reply is `done`, at most `within` s; returns the last reply.

        The world may be restarted meanwhile: BusError is raised if none answers at the end, or for too long.
        """
        deadline, patience = time.monotonic() + within, _SOON
        while True:
            try:
                reply = self.operate(operation, patience)
            except BusError as error:
                if time.monotonic() >= min(deadline, self._heard + _AWAY):
                    raise
                if patience < ANSWER:
                    self._warn(f"{error}; asks again")
                patience = ANSWER
            else:
                if done(reply) or time.monotonic() >= deadline:
                    return reply
            STOP.check()
            self._hear(_LOOK)

    def _hear(self, timeout: float) -> GoalStatus | None:
        """A published status, if one arrives within `timeout` s; raises BusError once the run has ended."""
        event = self._bus.receive(timeout)
        with suppress(MessageError):  # from another sender
            message = decode(event.key, event.payload) if isinstance(event, Sample) else None
            if isinstance(message, Result):
                raise BusError(f"run {self._run!r} is over")
            return cast(GoalStatus | None, message)
        return None

    def outcome(self, robot: int, number: int, within: float) -> GoalStatus:
        """Wait until a goal is reached, cancelled or given up; returns its status.
        Raises BusError after `within` s, if another order followed, the robot was removed, or the run ended.
        """
        self._bus.subscribe(robot_key(self._run, robot, "goalstatus"), world_key(self._run, "result"))
        deadline, status = time.monotonic() + within, None
        while True:
            remaining = deadline - time.monotonic()
            if status is None or status.robot != robot or status.number < number:  # of an earlier call
                status = self._repeat(None, lambda _: True, remaining).goal(robot)
            if status is None or (status.number != number and status.status != "cancelled"):
                raise BusError(f"there is no robot {robot} with order {number}, or no longer")
            if status.status != "under way":
                return status
            if remaining <= 0.0:
                raise BusError(f"order {number} of robot {robot} has not ended within {within:g} s")
            status = self._hear(min(remaining, _PAUSE))


@contextmanager
def operating(
    run: str, router: str | None = None, secure: Path | None = None, within: float = ANSWER
) -> Iterator[Operator]:
    """An operator of `run` with its own session, through the router at this endpoint (by default the usual
    one), with the operator's key of the directory `secure`, if any.

    Raises:
        BusError: no router is reached within `within` s.
        CertificateError: the keys are of another run, or do not fit.
        UsageError: the endpoint is invalid.
    """
    membership = KeyRing(secure)
    name = membership.named_run(run)
    with closing(ZenohBus(membership.client(OPERATOR, (router,), timeout=within))) as bus:
        yield Operator(bus, name)


def _other_runs(bus: Bus, run: str) -> str:
    """The runs that have a world on this network, if `run` has none, for a message; otherwise empty."""
    runs = {token.split("/")[1] for token in bus.tokens(world_tokens("*"))}
    return f" (runs with a world: {', '.join(sorted(runs))})" if runs and run not in runs else ""


def probed_key(run: str, role: str) -> str:
    """Key of a stream that a live process publishes regularly: a robot's health, the world's clock.
    Raises UsageError for a role without such a stream.
    """
    if role == WORLD:
        return world_key(run, "clock")
    robot = role.removeprefix("robot-")
    if role == ROUTER or not (robot.isascii() and robot.isdecimal()):
        raise UsageError(f"{role!r} cannot be probed: name the world or a robot, such as robot-3")
    return robot_key(run, int(robot), "health")


def probe(connection: Connection, run: str, role: str, within: float) -> None:
    """Return once a message of `role` arrives; raises BusError after `within` s or without a router."""
    key = probed_key(run, role)
    with closing(ZenohBus(connection)) as bus:
        bus.subscribe(key)
        deadline = time.monotonic() + within
        while (remaining := deadline - time.monotonic()) > 0.0:
            event = bus.receive(remaining)
            if isinstance(event, Sample):
                decode(event.key, event.payload)
                return
        raise BusError(f"nothing received from {role} under {key} for {within:g} s{_other_runs(bus, run)}")
