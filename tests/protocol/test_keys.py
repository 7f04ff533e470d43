"""The grammar of key expressions: what is built parses back, everything else is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.errors import KeyGrammarError
from protocol.keys import (
    ROBOT_STREAMS,
    WORLD_STREAMS,
    Address,
    checked_run,
    every_robot,
    parse,
    robot_key,
    world_key,
)

runs = st.from_regex(r"[A-Za-z0-9_-]{1,30}", fullmatch=True)
ids = st.integers(1, 999_999_999)


@given(runs, ids, st.sampled_from(ROBOT_STREAMS), st.sampled_from(WORLD_STREAMS))
def test_keys_parse_back(run: str, robot: int, its: str, worlds: str) -> None:
    assert parse(robot_key(run, robot, its)) == Address(run, robot, its)
    assert parse(world_key(run, worlds)) == Address(run, None, worlds)


@pytest.mark.parametrize(
    "key",
    [
        "",
        "disknav/a/robot/0/state",
        "disknav/a/robot/01/state",
        "disknav/a/robot/-1/state",
        "disknav/a/robot/1/clock",
        "disknav/a/world/state",
        "disknav/a/robot/1/state/",
        "/disknav/a/robot/1/state",
        "disknav/a/robot/1/state\n",
        "disknav//robot/1/state",
        "disknav/a*/robot/1/state",
        "disknav/a/robot/*/state",
        "disknav/a/robot/1234567890/state",
        "disknav/a/robot/\N{ARABIC-INDIC DIGIT ONE}/state",
        "other/a/robot/1/state",
    ],
)
def test_foreign_keys_are_refused(key: str) -> None:
    with pytest.raises(KeyGrammarError):
        parse(key)


@pytest.mark.parametrize("run", ["", "a/b", "a b", "*", "a**", "ä", "a\n", "$x", "a#"])
def test_a_run_name_that_cannot_stand_in_a_key_is_refused(run: str) -> None:
    with pytest.raises(KeyGrammarError, match="letters, digits"):
        checked_run(run)


def test_unknown_streams_are_refused_with_the_known_ones() -> None:
    with pytest.raises(KeyGrammarError, match="tick, state"):
        robot_key("a", 1, "clock")
    with pytest.raises(KeyGrammarError, match="clock, truth"):
        world_key("a", "state")
    with pytest.raises(KeyGrammarError, match="tick, state"):
        every_robot("a", "clock")
