"""Mistakes in scenario files: all are said at once, each once, with its path."""

import json
from pathlib import Path
from typing import Any

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import parse_document
from tests.protocol.scenario.scenario_texts import ROBOTS, THIRD, document, problems


@pytest.mark.parametrize(
    "mistake",
    json.loads((Path(__file__).parent / "mistakes.json").read_text()),
    ids=lambda each: next(iter(each["problems"])),
)
def test_mistakes_keep_their_words(mistake: dict[str, Any]) -> None:
    """Everything that is said of scenarios that people got wrong, word by word."""
    assert problems(mistake["toml"].replace("{robots}", ROBOTS)) == mistake["problems"]


def test_everything_is_said_at_once_even_what_lies_between_fields() -> None:
    text = "seed = 'x'\n[control]\nlaw = 3\n" + ROBOTS + THIRD.replace("goal = [0.0, 0.2]", "goal = ['a', 1]")
    assert problems(text).keys() == {"seed", "control.law", "robots[2].goal[0]", "robots[2].start"}


def test_events_follow_each_other_in_time_not_in_the_file() -> None:
    faults = [(3.0, "resume"), (1.0, "pause"), (4.0, "kill"), (5.0, "restart"), (6.0, "pause")]
    good = document() | {"process": [{"robot": 1, "at": at, "event": event} for at, event in faults]}
    assert len(parse_document(good).process) == 5
    bad = good | {"process": [*good["process"], {"robot": 1, "at": 4.5, "event": "pause"}]}
    with pytest.raises(ScenarioError, match=r"process\[5\].event: robot 1 is killed at 4.5 s"):
        parse_document(bad)


def test_many_overlaps_are_summed_up() -> None:
    heap = [{"id": n, "radius": 0.04, "start": [0, 0], "goal": [0, 0]} for n in range(1, 301)]
    with pytest.raises(ScenarioError) as caught:
        parse_document({"robots": heap})
    assert len(caught.value.problems) == 2 * 299
    assert str(caught.value.problems[-1]).endswith("robot 3 by 0.08 m and 296 more")


def test_text_in_another_encoding_is_named_as_such() -> None:
    """What is left of settings that a command line in Latin-1 gives."""
    with pytest.raises(ScenarioError) as caught:
        parse_document(document() | {"name": "caf\udce9", "link": {"l\udce9": 1}, "control": {"k": "\udce9"}})
    assert str(caught.value).isascii()
    assert {problem.path for problem in caught.value.problems} == {"name", "link.?", "control.k"}
    assert "must be a string, not text that is not Unicode" in str(caught.value)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        (
            "process",
            [{"robot": 1, "at": 1.0, "event": "restart"}] * 10_001,
            "at most 10000 elements, has 10001",
        ),
        ("sensing", [{}] * 1001, "at most 1000 elements, has 1001"),
        ("name", "x" * 201, "at most 200 characters"),
        ("name", "a\x1b[31m", "no control characters"),
        ("description", "x" * 10_001, "at most 10000 characters"),
    ],
)
def test_a_scenario_that_no_message_has_room_for_is_refused(key: str, value: Any, words: str) -> None:
    with pytest.raises(ScenarioError, match=words) as caught:
        parse_document(document() | {key: value})
    assert [problem.path for problem in caught.value.problems] == [key]


def test_partitions_that_no_message_has_room_for_are_refused() -> None:
    robots = [{"id": n, "radius": 0.04, "start": [0.1 * n, 0], "goal": [0.1 * n, 0]} for n in range(1, 101)]
    apart = [{"from": n, "until": n + 1, "groups": [list(range(1, 101))]} for n in range(501)]
    with pytest.raises(ScenarioError, match="name 50100 robots; at most 50000 are allowed"):
        parse_document({"workspace": {"radius": 20}, "robots": robots, "link": {"partition": apart}})


def test_a_room_in_which_no_robot_could_plan_for_parts_is_refused() -> None:
    part = "[[parts]]\nradius = {0}\nstart = [0, 20.0]\ngoal = [0, -20.0]\n"
    room = "[workspace]\nradius = 1000.0\n"
    (path, text), *others = problems(room + part.format(0.04) + ROBOTS).items()
    assert (path, others) == ("workspace", [])
    assert "too large to carry disks of 0.04 m" in text
