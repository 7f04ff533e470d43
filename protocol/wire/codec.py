"""Encoding and checked decoding of messages.

Whatever arrives is untrusted. A payload is accepted only if its size, version, type, shape and
numbers are right and it speaks under its own key; else MessageError names one of `REASONS`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import msgspec

from protocol.errors import MessageError
from protocol.messages import (
    AnyMessage,
    Clock,
    Command,
    GoalStatus,
    Health,
    Message,
    Proposal,
    Sense,
    State,
    Summary,
    Tick,
    Truth,
)
from protocol.wire.reader import reader

LARGEST: Final = 1e100  # a number whose square is one, too; nothing in a run comes near it
REASONS = ("key", "oversize", "version", "type", "shape", "not-finite", "identity", "epoch")

_pack = msgspec.msgpack.encode


def _with_defaults(message: type[Message]) -> tuple[tuple[str, object], ...]:
    """Fields that may be left out, and what they are then, from the last one on."""
    defaults = message.__struct_defaults__
    fields = message.__struct_fields__[-len(defaults) :]
    return tuple(zip(reversed(fields), reversed(defaults), strict=True))


_OF_TICK: Final = _with_defaults(Tick)
_OF_COMMAND: Final = _with_defaults(Command)


def encode(message: Message) -> bytes:
    """A message as it travels. Ticks and Commands cross links between hosts in every tick: they end with the
    last field that is not as it is by default."""
    if isinstance(message, Tick):
        return _shortened(message, _OF_TICK)
    if isinstance(message, Command):
        return _shortened(message, _OF_COMMAND)
    return _pack(message)


def _shortened(message: Message, fields: tuple[tuple[str, object], ...]) -> bytes:
    """Without `fields` at the end that are as by default: each of those is one byte of a short array."""
    payload, spare = _pack(message), 0
    for name, default in fields:
        if getattr(message, name) != default:
            break
        spare += 1
    return bytes((payload[0] - spare,)) + payload[1 : len(payload) - spare] if spare else payload


def decode(key: str, payload: bytes) -> AnyMessage:
    """Decode what arrived under `key`.

    Raises:
        MessageError: with `reason` in `REASONS`.
    """
    of_key = reader(key)
    message = of_key.read(payload)
    check_finite(of_key.stream, message)
    return message


def check_finite(stream: str, message: AnyMessage) -> None:
    """Refuse a message of `stream` that holds a number beyond `LARGEST`, or none.

    Raises:
        MessageError: not-finite.
    """
    if not _is_finite(message):
        raise MessageError("not-finite", f"{stream}: holds a number that is infinite, absurd or none")


def _is_finite(message: AnyMessage) -> bool:
    """Whether all numbers of a message are sane. A sum of magnitudes is so only if all its terms are: for
    those of every tick that costs a third of looking at each number, which is left to the larger sums."""
    if isinstance(message, State):
        total = _state_sum(message)
    elif isinstance(message, Command):
        total = abs(message.velocity[0]) + abs(message.velocity[1])
        others = (message.report, message.letter, message.handles, message.slice)
        if any(each is not None for each in others):
            total += sum(map(abs, _command_numbers(message)))
    elif isinstance(message, Summary):
        total = 0.0  # whoever unpacks it looks at its numbers
    elif isinstance(message, Tick) and message.roster is None and not message.letters:
        total = 0.0 if message.sense is None else sum(map(abs, _sense_numbers(message.sense)))
        total += 0.0 if message.goal is None else abs(message.goal[0]) + abs(message.goal[1])
    else:
        return all(map(_is_sane, _numbers(message)))
    return _is_sane(total) or all(map(_is_sane, _numbers(message)))


def _is_sane(number: float) -> bool:
    return -LARGEST <= number <= LARGEST


def _state_sum(state: State) -> float:
    """Sum of the magnitudes of all floating-point numbers of a State."""
    vx, vy = state.desired
    total = state.bound + state.gamma + state.slice + abs(vx) + abs(vy)
    if state.position is not None:
        x, y = state.position
        total += abs(x) + abs(y)
    for line in state.proposals:
        total += abs(line.nx) + abs(line.ny) + abs(line.offset)
    if state.claim is not None:
        total += state.claim.cost + state.claim.radius
    return total


def _numbers(message: AnyMessage) -> Iterator[float]:
    """All floating-point numbers of a message."""
    if isinstance(message, State):
        return _state_numbers(message)
    if isinstance(message, Command):
        return _command_numbers(message)
    if isinstance(message, Tick):
        return _tick_numbers(message)
    return _watched_numbers(message)


def _command_numbers(command: Command) -> Iterator[float]:
    yield from command.velocity
    if command.report is not None:
        yield from (*command.report.position, command.report.bound)
    if command.letter is not None:
        yield from _line_numbers(command.letter.proposals)
    if command.slice is not None:
        yield command.slice
    if command.handles is not None:
        yield from (command.handles.radius, *(command.handles.place or ()))


def _state_numbers(state: State) -> Iterator[float]:
    yield from state.desired
    yield state.bound
    yield state.gamma
    yield state.slice
    if state.position is not None:
        yield from state.position
    yield from _line_numbers(state.proposals)
    if state.claim is not None:
        yield state.claim.cost
        yield state.claim.radius


def _line_numbers(proposals: tuple[Proposal, ...]) -> Iterator[float]:
    for line in proposals:
        yield line.nx
        yield line.ny
        yield line.offset


def _sense_numbers(sense: Sense) -> tuple[float, ...]:
    motion = sense.motion
    return (
        *(sense.position or ()),
        sense.bound,
        *sense.displacement,
        sense.displacement_bound,
        *(() if motion is None else (*motion.velocity, motion.heading, *motion.stop)),
    )


def _tick_numbers(tick: Tick) -> Iterator[float]:
    yield from () if tick.sense is None else _sense_numbers(tick.sense)
    yield from tick.goal or ()
    for member in () if tick.roster is None else tick.roster.members:
        yield from (member.radius, member.bound, *(member.position or ()))
    for letter in tick.letters:
        yield from _line_numbers(letter.proposals)


def _watched_numbers(message: AnyMessage) -> Iterator[float]:
    if isinstance(message, Clock):
        yield from (message.time, message.clearance, message.phi)
        for each in message.standing:
            yield from each.position
    elif isinstance(message, Truth):
        yield message.clearance
        yield message.phi
        for position in message.positions:
            yield from position
    elif isinstance(message, GoalStatus):
        yield from message.goal
    elif isinstance(message, Health):
        yield message.bound
        for _, nx, ny, limit in message.lines:
            yield from (nx, ny, limit)
