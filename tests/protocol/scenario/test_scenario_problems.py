"""Mistakes in scenario files: all are said at once, each once, with its path."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import parse_document
from tests.protocol.scenario.scenario_texts import ROBOTS, THIRD, document, problems


def test_the_issue_in_one_line() -> None:
    assert problems(ROBOTS + THIRD) == {"robots[2].start": "overlaps robot 1 by 0.013 m"}


@pytest.mark.parametrize(
    ("text", "path", "words"),
    [
        ("nmae = 'x'" + ROBOTS, "nmae", "did you mean `name`?"),
        ("[control]\nkay = 3" + ROBOTS, "control.kay", "did you mean `k`"),
        ("[control]\nzzz = 3" + ROBOTS, "control.zzz", "known are `law`"),
        (ROBOTS + "gaol = 3", "robots[1].gaol", "did you mean `goal`?"),
        (
            "[[link.partition]]\nfrom = 1\nuntil = 2\ngroups = [[1]]\nform = 1" + ROBOTS,
            "link.partition[0].form",
            "`from`",
        ),
        ("[sensing]\nnoise = '1'" + ROBOTS, "sensing.noise", 'must be a number, not the string "1"'),
        ("[[sensing]]\nnoise = '1'" + ROBOTS, "sensing[0].noise", "must be a number"),
        ("[sensing]\nnoise = true" + ROBOTS, "sensing.noise", "must be a number, not true"),
        ("[sensing]\nnoise = nan" + ROBOTS, "sensing.noise", "finite"),
        ("[sensing]\nnoise = inf" + ROBOTS, "sensing.noise", "finite"),
        ("[sensing]\nnoise = -0.1" + ROBOTS, "sensing.noise", "at least 0"),
        ("[sensing]\nnoise_bound = -0.1" + ROBOTS, "sensing.noise_bound", "at least 0"),
        ("[sensing]\ndropout = 1.5" + ROBOTS, "sensing.dropout", "at most 1"),
        (
            "[sensing]\ncontradiction = 'guess'" + ROBOTS,
            "sensing.contradiction",
            "must be 'stand' or 'newest'",
        ),
        ("[sensing]\nbias = [1]" + ROBOTS, "sensing.bias", "2 elements"),
        ("[sensing]\nrobots = []" + ROBOTS, "sensing.robots", "empty"),
        ("[sensing]\nrobots = [1, 9]" + ROBOTS, "sensing.robots[1]", "no robot 9"),
        ("[sensing]\ndelay = 'x'" + ROBOTS, "sensing.delay", "a number of seconds or an array [low, high]"),
        ("[link]\ndelay = -1" + ROBOTS, "link.delay", "at least 0, is -1"),
        ("[link]\ndelay = [1, -1]" + ROBOTS, "link.delay[1]", "at least 0"),
        ("[link]\ndelay = [1]" + ROBOTS, "link.delay", "2 elements, has 1"),
        ("[link]\ndelay = [1, 2, 3]" + ROBOTS, "link.delay", "2 elements, has 3"),
        ("[link]\ndelay = [0.3, 0.1]" + ROBOTS, "link.delay", "above the high end 0.1"),
        ("[control]\nk = 'automatic'" + ROBOTS, "control.k", 'a number, "auto" or "certified"'),
        (
            "[control]\nadditions = [1]" + ROBOTS,
            "control.additions[0]",
            "must be 'obstacles', 'jams', 'late-states', 'pace' or 'escape', not 1",
        ),
        ("[control]\nk = 0" + ROBOTS, "control.k", "at least 1e-09, is 0"),
        ("[control]\nlaw = 'orka'" + ROBOTS, "control.law", "gradient or reciprocal, or your own"),
        ("[time]\nstep = 2.0\nlimit = 1.0" + ROBOTS, "time.limit", "less than one step"),
        ("[time]\nstep = 1e-9\nlimit = 10.0" + ROBOTS, "time.limit", "more than 1e+09 steps"),
        ("[time]\nlimit = 1e300" + ROBOTS, "time.limit", "at most"),
        ("time = 3" + ROBOTS, "time", "must be a table"),
        ("link = [1]" + ROBOTS, "link", "must be a table, not an array"),
        ("name = 2020-01-01" + ROBOTS, "name", "must be a string, not a date"),
        ("seed = 1.0" + ROBOTS, "seed", "must be a whole number"),
        (f"seed = {10**30}" + ROBOTS, "seed", "whole number"),
        ("seed = -1" + ROBOTS, "seed", "at least 0"),
        ("[workspace]\nradius = 0.03" + ROBOTS, "robots[0].radius", "does not fit"),
        ("[workspace]\nradius = 0.23" + ROBOTS, "robots[1].start", "reaches 0.01 m out of the workspace"),
        ("[[process]]\nrobot = 7\nat = 1\nevent = 'kill'" + ROBOTS, "process[0].robot", "no robot 7"),
        ("[[process]]\nrobot = 1\nat = 1\nevent = 'kil'" + ROBOTS, "process[0].event", "'kill', 'pause'"),
        (
            "[[process]]\nrobot = 1\nat = 1\nevent = 'resume'" + ROBOTS,
            "process[0].event",
            "robot 1 is running at 1 s",
        ),
        (
            "[[link.partition]]\nfrom = 2\nuntil = 2\ngroups = [[1]]" + ROBOTS,
            "link.partition[0].until",
            "not after",
        ),
        (
            "[[link.partition]]\nfrom = 1\nuntil = 2\ngroups = [[1, 5]]" + ROBOTS,
            "link.partition[0].groups[0][1]",
            "no robot 5",
        ),
        (
            "[[link.partition]]\nfrom = 1\nuntil = 2\ngroups = [[1], [1]]" + ROBOTS,
            "link.partition[0].groups[1][0]",
            "already",
        ),
        (
            ROBOTS + THIRD.replace("id = 3", "id = 2").replace("0.067", "0.2"),
            "robots[2].id",
            "the id of robots[1]",
        ),
        (
            ROBOTS + THIRD.replace("0.067", "0.2").replace("[0.0, 0.2]", "[0.1, 0.15]"),
            "robots[2].goal",
            "overlaps robot 1 by 0.03",
        ),
        (ROBOTS + THIRD.replace("0.067", "0.08"), "robots[2].start", "touches robot 1"),
        ("robots = []", "robots", "must not be empty"),
        ("", "robots", "is missing"),
        (ROBOTS + "[[robots]]\nid = 3\nradius = 0.01\nstart = [0.2, 0.0]", "robots[2].goal", "is missing"),
    ],
)
def test_one_problem_is_said_once_where_it_is(text: str, path: str, words: str) -> None:
    found = problems(text)
    assert words in found[path]
    if "does not fit" not in words:
        assert list(found) == [path]


@pytest.mark.parametrize(
    "mistake",
    json.loads((Path(__file__).parent / "mistakes.json").read_text()),
    ids=lambda each: each["toml"][:40],
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


@pytest.mark.slow
def test_partitions_that_no_message_has_room_for_are_refused() -> None:
    partition = "[[link.partition]]\nfrom = {0}\nuntil = {1}\ngroups = [[1], [2]]\n"
    text = "".join(partition.format(n, n + 1) for n in range(25_001))
    found = problems(text + ROBOTS)
    assert found == {
        "link.partition": "the groups of all partitions name 50002 robots; at most 50000 are allowed"
    }


def test_a_room_in_which_no_robot_could_plan_for_parts_is_refused() -> None:
    part = "[[parts]]\nradius = {0}\nstart = [0, 20.0]\ngoal = [0, -20.0]\n"
    room = "[workspace]\nradius = 1000.0\n"
    (path, text), *others = problems(room + part.format(0.04) + ROBOTS).items()
    assert (path, others) == ("workspace", [])
    assert "too large to carry disks of 0.04 m" in text
