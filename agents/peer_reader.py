"""Reads a peer's States for one robot. In a large fleet nearly all that they say of lines concerns
other pairs, and stays unread."""

from __future__ import annotations

from typing import Any, Final, Literal, final, get_type_hints

import msgspec

from agents.peer_state import PeerState, said_to
from protocol.codec import check_finite, encode
from protocol.messages import Answer, Proposal, State
from protocol.reader import DAMAGED, Reader
from protocol.streams import STREAMS

Vector = tuple[float, float]
_Unlined = tuple[
    str, int, int, int, Vector | None, float, float, float, Vector, msgspec.Raw, msgspec.Raw
]  # a State whose proposals and answers are not looked into


def _decoder() -> Any:
    """Of a State: its last two fields are left as they are, and all others read as declared."""
    form: Any = tuple
    literal: Any = Literal
    declared = get_type_hints(State, include_extras=True)
    fields = [declared[name] for name in State.__struct_fields__[:-2]]
    tag = literal[State.__struct_config__.tag]
    return msgspec.msgpack.Decoder(form[(tag, *fields, msgspec.Raw, msgspec.Raw)]).decode


def _mark(robot: int, *, owned: bool) -> bytes:
    """How a line addressed to `robot` begins in a State: a proposal if the speaker has `owned` it, else an
    answer. Where this is not found there is none; where it is found, there may be one."""
    line = Proposal(robot, 0, 0, 0.0, 0.0, 0.0) if owned else Answer(robot, 0, 0, 0)
    return encode(line)[: 1 + len(encode(robot))]


_decode = _decoder()
_LIMIT: Final = STREAMS["state"].limit


@final
class PeerReader:
    """Decodes what arrives under the state key of `peer`, for `robot`.

    Args:
        robot: own id.
        peer: the speaker's.
        radius: of the peer, m.
        oldest: its first incarnation in this run.

    Attributes:
        oldest: as given; earlier lives are no concern of this run.
    """

    __slots__ = ("_decode", "_mark", "_peer", "_radius", "_reader", "_robot", "oldest")

    def __init__(self, robot: int, peer: int, radius: float, oldest: int = 0) -> None:
        self._robot, self._peer, self._radius = robot, peer, radius
        self.oldest = oldest
        self._reader = Reader("state", peer)
        self._decode = _decode
        self._mark = _mark(robot, owned=peer < robot)

    def read(self, payload: bytes) -> PeerState:
        """What the State in `payload` says to this robot.

        Raises:
            MessageError: it is none, or another robot's; or a number in what concerns this robot is
                infinite, or none.
        """
        state = self._unlined(payload)
        if state is not None:
            return state
        message = self._reader.read(payload)
        assert isinstance(message, State)
        state = said_to(self._robot, message, self._radius)
        if not state.is_finite:
            check_finite("state", message)
        return state

    def _unlined(self, payload: bytes) -> PeerState | None:
        """A sound State without lines for this robot; None if there may be one, or anything to find fault
        with."""
        if len(payload) > _LIMIT:
            return None
        try:
            fields: _Unlined = self._decode(payload)
        except DAMAGED:
            return None
        _, robot, incarnation, tick, position, bound, gamma, slice_norm, desired, proposals, answers = fields
        if robot != self._peer:
            return None
        # One byte is an empty array. `in` would first try whether the mark is a number: `find` is quicker.
        if (len(proposals) > 1 or len(answers) > 1) and payload.find(self._mark) >= 0:
            return None
        state = PeerState(
            robot, incarnation, tick, position, bound, gamma, slice_norm, desired, radius=self._radius
        )
        return state if state.is_finite else None
