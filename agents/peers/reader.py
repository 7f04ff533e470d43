"""Reads a peer's States for one robot. In a large fleet nearly all that they say of lines concerns
other pairs: that is checked, and nothing is made of it.

By `protocol.codec` and `addressed_to` alone a State takes 1.5 us instead of 0.2: to a robot among 32
that would be another 45 us a tick, as much as all the rest of its step takes.
"""

from __future__ import annotations

from typing import Final, final

import msgspec

from agents.peers.state import PeerState, Plausible, addressed_to
from protocol.codec import Reader
from protocol.cursor import Cursor
from protocol.errors import MessageError
from protocol.messages import HIGHEST_ID, LARGEST, UNIT, Answer, Proposal, State
from protocol.streams import STREAMS

_COMPILED: Final = not __file__.endswith(".py")  # as Python, a cursor is slower than msgspec
_LIMIT: Final = STREAMS["state"].limit
_ANY: Final = Plausible(LARGEST, LARGEST, LARGEST**2, LARGEST)
_FIELDS = 1 + len(State.__struct_fields__)  # the tag and all others


@final
class PeerReader:
    """Decodes what arrives under the state key of `peer`, for `robot`.

    Args:
        robot: own id.
        peer: the speaker's.
        epoch: of the own coordinator.
        limits: what a State can truly say.
    """

    __slots__ = ("_begin", "_epoch", "_limits", "_peer", "_reader", "_robot")

    def __init__(self, robot: int, peer: int, epoch: int = 0, limits: Plausible = _ANY) -> None:
        self._robot, self._peer, self._epoch = robot, peer, epoch
        self._reader = Reader("state", peer)
        self._limits = limits
        whole = msgspec.msgpack.encode([State.__struct_config__.tag, peer, *[None] * (_FIELDS - 2)])
        self._begin = whole[: 2 - _FIELDS]

    def read(self, payload: bytes) -> PeerState:
        """What the State in `payload` says to this robot.

        Raises:
            MessageError: it is none, another robot's, or says what cannot be, of any pair: what one refuses
                all refuse, so that it is the speaker that is given up.
        """
        try:
            state = self._usual(payload) if _COMPILED else None
        except IndexError:
            state = None
        return self._any(payload) if state is None else state

    def _usual(self, payload: bytes) -> PeerState | None:
        """A sound State as libraries write it; None, or IndexError, if it is anything else."""
        if len(payload) > _LIMIT or not payload.startswith(self._begin):
            return None
        cursor = Cursor(payload, len(self._begin))
        incarnation, tick = cursor.count(), cursor.count()
        placed, x, y = not cursor.none(), 0.0, 0.0
        if placed:
            cursor.enter(2)
            x, y = cursor.number(), cursor.number()
        bound, gamma, slice_norm = cursor.number(), cursor.number(), cursor.number()
        cursor.enter(2)
        vx, vy = cursor.number(), cursor.number()
        if cursor.count() != self._epoch:
            return None
        proposals, answers = self._proposals(cursor), self._answers(cursor)
        if not cursor.none():
            return None
        if cursor.at != len(payload) or bound < 0.0 or gamma < 0.0 or slice_norm < 0.0:
            return None
        if not (slice_norm <= LARGEST and abs(vx) <= LARGEST and abs(vy) <= LARGEST):
            return None
        state = PeerState(
            self._peer,
            incarnation,
            tick,
            placed,
            x,
            y,
            bound,
            gamma,
            slice_norm,
            vx,
            vy,
            proposals=proposals,
            answers=answers,
        )
        return state if self._limits.allows(state) else None

    def _proposals(self, cursor: Cursor) -> tuple[Proposal, ...]:
        """Those to this robot."""
        found: tuple[Proposal, ...] = ()
        for _ in range(cursor.array()):
            cursor.enter(6)
            peer, binding, number = _identity(cursor), cursor.count(), cursor.count()
            nx, ny, offset = cursor.number(), cursor.number(), cursor.number()
            if not (abs(nx) <= UNIT and abs(ny) <= UNIT and abs(offset) <= LARGEST):
                raise IndexError("no line")
            if peer == self._robot:
                found = (*found, Proposal(peer, binding, number, nx, ny, offset))
        return found

    def _answers(self, cursor: Cursor) -> tuple[Answer, ...]:
        """Those to this robot."""
        found: tuple[Answer, ...] = ()
        for _ in range(cursor.array()):
            cursor.enter(4)
            peer, binding, held, seen = _identity(cursor), cursor.count(), cursor.count(), cursor.count()
            if peer == self._robot:
                found = (*found, Answer(peer, binding, held, seen))
        return found

    def _any(self, payload: bytes) -> PeerState:
        message = self._reader.read(payload)
        assert isinstance(message, State)
        if message.epoch != self._epoch:
            raise MessageError("epoch", f"state: of epoch {message.epoch}, this robot is of {self._epoch}")
        state = addressed_to(self._robot, message)
        if not self._limits.allows(state):
            raise MessageError("shape", f"state of robot {self._peer}: it cannot be where it says")
        if state.claim is not None and state.claim.radius > self._limits.part:
            state.claim = msgspec.structs.replace(state.claim, radius=self._limits.part)
        return state


def _identity(cursor: Cursor) -> int:
    robot = cursor.count()
    if not 1 <= robot <= HIGHEST_ID:
        raise IndexError("nobody's id")
    return robot
