"""Operations on a running fleet, as requests, and the replies of its world.

A request under `world/operation` has the form of an entry of a scenario's `[[orders]]`:

    {"goal": {"robot": 3, "points": [[x, y], ...]}}   go to these points, one after another; an empty
                                                      list cancels the order.
                                                      Besides: `queue`, `patrol`, `within` (s)
    {"add": {"id": 7, "radius": r, "start": [x, y], "goal": [x, y]}}
                                                      a disk appears once every robot keeps clear of its
                                                      place; its process may join then
    {"remove": 7}                                     the robot ends, its disk is removed
    {"place": {"center": [x, y], "radius": r}}        an obstacle appears once every robot keeps clear of
    {"place": {"points": [[x, y], ...]}}              its place: a disk, or a convex polygon
    {"take": 2}                                       the obstacle has been removed
    {"halt": true}                                    emergency stop: all robots brake in the present tick,
                                                      external bases in the next, and stand
    {"release": 3}                                    the robots may move again, unless another stop has been
                                                      requested since the third

An empty request returns the state alone. The reply has `accepted`, `number` of the goal or obstacle, `text`
(the reason of a refusal, or a warning), and the state: the present `tick`, `halted`, the number of requested
`stops` so far, `moving` (robots that still move after a stop), `roster`, `obstacles` that are present or
announced, and `goals` of all robots, as in a `GoalStatus`. A stop has succeeded once `halted` is true and
`moving` is empty.

A request under `world/steering` changes the pace of a lock-step run: `{"pause": true}` pauses the clock,
`{"pause": false}` resumes it, `{"step": n}` pauses it after n more ticks, `{"speed": x}` limits simulated
seconds per second (0: as fast as the machine allows). The reply has the settings in force: `paused`, `steps`
still allowed, `speed`. They change the times of ticks, never their content; in real time they have no effect.

Requests are maps in msgpack or, for users and stock tools, in JSON; the reply is in the form of the request.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from protocol.codec import DAMAGED
from protocol.errors import MessageError
from protocol.messages import Count, GoalStatus, Id, PlacedObstacle, Roster
from protocol.scenario.body import NonNegative
from protocol.scenario.model import ACTIONS, Operation
from protocol.scenario.tables import read_table, written

LIMIT = 16 * 1024  # bytes of a request

T = TypeVar("T")


class Outcome(msgspec.Struct, frozen=True):
    """The outcome of an operation."""

    accepted: bool
    number: Count = 0  # of the goal, as its status names it, or of the obstacle; 0 for other operations
    text: str = ""  # why it was refused, or a warning


class Reply(Outcome, frozen=True, kw_only=True):
    """The outcome of an operation, and the state of the run after it."""

    tick: Count  # the present one
    halted: bool = False  # whether all robots must stand
    stops: Count = 0  # requests for an emergency stop so far, whose number `release` names
    moving: tuple[Id, ...] = ()  # robots that do not stand yet; empty unless `halted`
    roster: Roster = Roster(0, ())
    obstacles: tuple[PlacedObstacle, ...] = ()  # all that are present or announced
    goals: tuple[GoalStatus, ...] = ()  # of all robots, by increasing id

    def goal(self, robot: int) -> GoalStatus | None:
        """The goal of one robot; None if there is no such robot."""
        return next((status for status in self.goals if status.robot == robot), None)


@dataclass(frozen=True, slots=True)
class Steer:
    """A change of the pace; None leaves a setting as it is."""

    pause: bool | None = None
    step: Annotated[int, Meta(ge=0, le=1_000_000)] | None = None
    speed: NonNegative | None = None


class Steering(msgspec.Struct):
    """The pace in force."""

    paused: bool = False
    steps: int = 0
    speed: float = 0.0

    def apply(self, steer: Steer) -> None:
        """Change the given settings."""
        if steer.pause is not None:
            self.paused, self.steps = steer.pause, 0
        if steer.step is not None:
            self.paused, self.steps = True, self.steps + steer.step
        if steer.speed is not None:
            self.speed = steer.speed

    def allow(self) -> bool:
        """Whether a tick may begin now; uses up one step while paused."""
        if not self.paused:
            return True
        if self.steps == 0:
            return False
        self.steps -= 1
        return True


def read_operation(document: Any) -> Operation:
    """An operation from plain maps, arrays and values; raises MessageError with all its errors."""
    operation = _read(document, Operation)
    if len(operation.asked) != 1:
        how = f", not {' and '.join(operation.asked)}" if operation.asked else ""
        raise MessageError("shape", f"operation: name exactly one of {', '.join(ACTIONS)}{how}")
    return operation


def decode_operation(payload: bytes) -> Operation | None:
    """The operation of a request; None if it only asks for the state. Raises MessageError."""
    return read_operation(_document(payload, "operation")) if payload else None


def read_steer(document: Any) -> Steer:
    """A change of the pace from a plain map; raises MessageError."""
    return _read(document, Steer)


def decode_steer(payload: bytes) -> Steer:
    """The change of the pace in a request; raises MessageError."""
    return read_steer(_document(payload, "steer"))


def _document(payload: bytes, what: str) -> Any:
    if len(payload) > LIMIT:
        raise MessageError("oversize", f"{what}: {len(payload)} bytes, at most {LIMIT} are read")
    try:
        return msgspec.json.decode(payload) if is_json(payload) else msgspec.msgpack.decode(payload)
    except DAMAGED as error:
        raise MessageError("shape", f"{what}: {error}") from None


def _read(document: Any, table: type[T]) -> T:
    what = table.__name__.lower()
    if not isinstance(document, dict):
        raise MessageError("shape", f"{what}: must be a map")
    found, findings = read_table(document, table)
    if findings:
        text = "; ".join(f"{written(steps)}: {problem}" for steps, problem in findings)
        raise MessageError("shape", f"{what}: {text}")
    return found


def encode_reply(reply: msgspec.Struct, request: bytes) -> bytes:
    """Payload of a reply, in the form of the request."""
    return msgspec.json.encode(reply) if is_json(request) else msgspec.msgpack.encode(reply)


def decode_reply(payload: bytes, kind: type[T]) -> T:
    """A reply of `kind` in msgpack; raises MessageError."""
    try:
        return msgspec.msgpack.decode(payload, type=kind)
    except DAMAGED as error:
        raise MessageError("shape", f"reply: {error}") from None


def is_json(payload: bytes) -> bool:
    """Whether a request is JSON text, which begins unlike any msgpack map."""
    return payload[:1] in (b"{", b" ", b"\n", b"\t")
