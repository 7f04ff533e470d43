"""What is published, with messages of real runs to begin from."""

from __future__ import annotations

from random import Random

from agents.peers.reader import PeerReader
from agents.peers.state import PeerState
from protocol import keys
from protocol.codec import REASONS, decode, encode
from protocol.errors import KeyGrammarError, MessageError
from protocol.messages import State
from protocol.streams import STREAMS
from tests.fuzz.mutation import damaged_message
from tests.fuzz.target import Target
from tests.fuzz.targets.keys import draw_key
from tests.fuzz.traffic import traffic


def _draw_message(rng: Random) -> tuple[str, bytes]:
    samples = traffic()[rng.choice(tuple(STREAMS))]
    (key, valid), (_, other) = rng.choice(samples), rng.choice(samples)
    if rng.randrange(8) == 0:
        key = draw_key(rng)
    return key, damaged_message(valid, other, rng)


def _read_message(drawn: tuple[str, bytes]) -> bool:
    key, payload = drawn
    heard = _heard(key, payload)
    try:
        message = decode(key, payload)
    except MessageError as error:
        assert error.reason in REASONS, error.reason
        assert str(error)
        raise
    assert decode(key, encode(message)) == message
    if isinstance(message, State):
        assert heard is not None
        assert (heard.tick, heard.position, heard.desired) == (
            message.tick,
            message.position,
            message.desired,
        )
    return True


def _heard(key: str, payload: bytes) -> PeerState | None:
    """What the robot after the speaker of a State makes of it; None if it refuses."""
    try:
        address = keys.parse(key)
    except KeyGrammarError:
        return None
    if address.stream != "state" or address.robot is None:
        return None
    try:
        return PeerReader(address.robot + 1, address.robot).read(payload)
    except MessageError as error:
        assert error.reason in REASONS, error.reason
        return None


MESSAGES = {"message": Target(_draw_message, _read_message, MessageError, 60)}
