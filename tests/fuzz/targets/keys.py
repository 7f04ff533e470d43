"""The keys under which everything is said."""

from __future__ import annotations

from random import Random

from protocol import keys
from protocol.errors import KeyGrammarError
from protocol.keys import ROBOT_STREAMS, WORLD_STREAMS
from tests.fuzz.mutation import damaged_text
from tests.fuzz.target import Target


def draw_key(rng: Random) -> str:
    run = rng.choice(("demo", "a_b-9", "0", "x" * 60))
    robot = rng.choice((1, 7, 64, 999_999_999))
    valid = rng.choice(
        (f"disknav/{run}/robot/{robot}/{rng.choice(ROBOT_STREAMS)}",
         f"disknav/{run}/world/{rng.choice(WORLD_STREAMS)}",
         keys.robot_token(run, robot, "5c1f"), keys.world_token(run, "A_b-9"))
    )  # fmt: skip
    return damaged_text(valid, f"disknav/{run}/world/alive", rng) if rng.randrange(6) else valid


def _read_key(text: str) -> bool:
    run, robot, stream, session = keys.parse.__wrapped__(text)  # uncached: a cache of so many proves nothing
    keys.checked_run(run)
    if session:
        again = keys.world_token(run, session) if robot is None else keys.robot_token(run, robot, session)
    else:
        again = keys.world_key(run, stream) if robot is None else keys.robot_key(run, robot, stream)
    assert again == text
    return True


KEYS = {"key": Target(draw_key, _read_key, KeyGrammarError, 16)}
