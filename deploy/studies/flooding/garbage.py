"""What floods a fleet: payloads that nobody should have sent, under keys that somebody listens to."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

from protocol.keys import robot_key, world_key
from protocol.messages import Command, State
from protocol.streams import STREAMS
from protocol.wire.codec import encode

_STRANGER = 999  # an id that no roster has
_CYCLE = 2000  # messages until it begins anew


def garbage(run: str, robots: tuple[int, ...], seed: int = 0) -> list[tuple[str, bytes]]:
    """Keys and payloads of one cycle, in the order in which to send them.

    Nine in ten are random bytes, or messages with a hole, under the fleet's own keys; the others are
    well-formed states of a robot that does not exist, keys that are none, and payloads beyond the limit
    of their stream. None is a message that a receiver may accept.
    """
    rng = Random(seed)
    return [message for _ in range(_CYCLE // 20) for message in _score(run, robots, rng)]


def _score(run: str, robots: tuple[int, ...], rng: Random) -> Iterator[tuple[str, bytes]]:
    """Twenty messages."""
    for _ in range(9):
        yield (
            _fleet_key(run, robots, rng),
            b"\xc1" + rng.randbytes(rng.randint(0, 200)),
        )  # no msgpack begins so
    for _ in range(9):
        robot = rng.choice(robots)
        whole = encode(State(robot, 1, 0, (0.0, 0.0), 0.0, 0.0, 0.0, (0.0, 0.0)))
        yield robot_key(run, robot, "state"), whole[: rng.randint(1, len(whole) - 1)]
    if rng.randrange(2):
        stranger = State(_STRANGER, 1, 0, (0.0, 0.0), 0.0, 0.0, 0.0, (0.0, 0.0))
        yield robot_key(run, _STRANGER, "state"), encode(stranger)
    else:
        yield f"disknav/{run}/nowhere/{rng.randrange(8)}", encode(Command(1, 1, 0, (0.0, 0.0)))
    command = STREAMS["command"]
    yield robot_key(run, rng.choice(robots), command.name), rng.randbytes(command.limit + 1)


def _fleet_key(run: str, robots: tuple[int, ...], rng: Random) -> str:
    stream = rng.choice(("state", "state", "command", "tick", "clock"))
    return world_key(run, stream) if stream == "clock" else robot_key(run, rng.choice(robots), stream)
