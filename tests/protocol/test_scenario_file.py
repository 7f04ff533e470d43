"""Scenario files: whatever is wrong is said at once, with its path; whatever is right survives a file."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from protocol.errors import ScenarioError
from protocol.scenario import (
    Actuation,
    Control,
    Link,
    Partition,
    ProcessFault,
    RobotSpec,
    Scenario,
    Sensing,
    Time,
    Workspace,
)
from protocol.scenario_file import (
    apply_settings,
    json_schema,
    parse_document,
    parse_toml,
    read_scenario,
    write_toml,
)

ROBOTS = """
[[robots]]
id = 1
radius = 0.04
start = [0.0, 0.0]
goal = [0.1, 0.1]
[[robots]]
id = 2
radius = 0.04
start = [-0.2, 0.0]
goal = [-0.1, -0.1]
"""
THIRD = "[[robots]]\nid = 3\nradius = 0.04\nstart = [0.067, 0.0]\ngoal = [0.0, 0.2]\n"


def problems(text: str) -> dict[str, str]:
    """Path to text of everything that is wrong."""
    with pytest.raises(ScenarioError) as caught:
        parse_toml(text)
    found = {problem.path: problem.text for problem in caught.value.problems}
    assert len(found) == len(caught.value.problems)
    return found


def document() -> dict[str, Any]:
    robots = [{"id": n, "radius": 0.04, "start": [0.1 * n, 0.0], "goal": [-0.1 * n, 0.0]} for n in (1, 2)]
    return {"robots": robots}


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
        ("[sensing]\nbias = [1]" + ROBOTS, "sensing.bias", "2 elements"),
        ("[sensing]\nrobots = []" + ROBOTS, "sensing.robots", "empty"),
        ("[sensing]\nrobots = [1, 9]" + ROBOTS, "sensing.robots[1]", "no robot 9"),
        ("[sensing]\ndelay = 'x'" + ROBOTS, "sensing.delay", "a number of seconds or an array [low, high]"),
        ("[link]\ndelay = -1" + ROBOTS, "link.delay", "at least 0, is -1"),
        ("[link]\ndelay = [1, -1]" + ROBOTS, "link.delay[1]", "at least 0"),
        ("[link]\ndelay = [1]" + ROBOTS, "link.delay", "2 elements, has 1"),
        ("[link]\ndelay = [1, 2, 3]" + ROBOTS, "link.delay", "2 elements, has 3"),
        ("[link]\ndelay = [0.3, 0.1]" + ROBOTS, "link.delay", "above the high end 0.1"),
        ("[control]\nk = 'automatic'" + ROBOTS, "control.k", 'a number or "auto"'),
        ("[control]\nk = 0" + ROBOTS, "control.k", "at least 1e-09, is 0"),
        ("[control]\nlaw = 'orka'" + ROBOTS, "control.law", "'gradient', 'orca' or 'barrier'"),
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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a = \n", "line 1"),
        ("x = 1\nx = 2\ny = 3", "line 2"),
        ("[a]\nb = [1, 2\n", "not TOML"),
        ("a = " + "[" * 100_000, "not TOML"),
        ("a = " + "9" * 5000, "not TOML"),
    ],
)
def test_what_is_not_toml(text: str, words: str) -> None:
    assert words in problems(text)[""]


def test_files_that_cannot_be_read(tmp_path: Any) -> None:
    with pytest.raises(ScenarioError, match="No such file"):
        read_scenario(tmp_path / "none.toml")
    with pytest.raises(ScenarioError, match="cannot be read"):
        read_scenario(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match="not UTF-8"):
        read_scenario(binary)
    good = tmp_path / "good.toml"
    good.write_bytes(b"\xef\xbb\xbf" + ROBOTS.replace("\n", "\r\n").encode())
    assert read_scenario(good).ids == (1, 2)


def test_sensing_as_one_table_and_as_an_array() -> None:
    one = parse_toml("[sensing]\nnoise = 0.1" + ROBOTS)
    assert one.sensing == parse_toml("[[sensing]]\nnoise = 0.1" + ROBOTS).sensing == (Sensing(noise=0.1),)
    assert parse_toml(ROBOTS).sensing == (Sensing(),)


positive = st.floats(1e-9, 1e6)
nonnegative = st.floats(0, 1e6)
shares = st.floats(0, 1)
spans = nonnegative | st.tuples(nonnegative, nonnegative).map(lambda pair: (min(pair), max(pair)))
points = st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
IDS = (1, 7, 30)
some_ids = st.lists(st.sampled_from(IDS), min_size=1, unique=True).map(tuple)
partitions = st.builds(
    Partition,
    st.floats(0, 100),
    st.floats(101, 200),
    st.sampled_from([(), ((1,),), ((1, 7), (30,)), ((), (30, 1))]),
)


@st.composite
def scenarios(draw: st.DrawFn) -> Scenario:
    size = draw(st.floats(1e-3, 1e5))
    radii = [size * draw(st.floats(0.01, 0.1)) for _ in IDS]
    places = [(-0.5 * size, 0.3 * size), (0.1 * size, -0.5 * size), (0.5 * size, 0.5 * size)]
    goals = draw(st.permutations(places))
    robots = tuple(RobotSpec(*entry) for entry in zip(IDS, radii, places, goals, strict=True))
    step = draw(st.floats(1e-3, 1.0))
    laws = st.builds(
        Control,
        st.sampled_from(["gradient", "orca", "barrier"]),
        positive | st.just("auto"),
        st.sampled_from(["common", "own"]),
        st.sampled_from(["separating-lines", "none"]),
        positive,
    )
    sensing = st.builds(
        Sensing, spans, nonnegative, st.none() | nonnegative, points, shares, st.none() | some_ids
    )
    faults = st.builds(ProcessFault, st.sampled_from(IDS), nonnegative, st.just("restart"))
    return Scenario(
        robots,
        draw(texts),
        draw(texts),
        draw(st.integers(0, 2**63 - 1)),
        Workspace(size),
        Time(step, draw(st.floats(1.0, 1e5)), draw(positive), draw(positive), draw(positive)),
        draw(laws),
        draw(st.lists(sensing, max_size=3).map(tuple)),
        draw(
            st.builds(Link, spans, nonnegative, shares, shares, st.lists(partitions, max_size=2).map(tuple))
        ),
        draw(st.lists(faults, max_size=3).map(tuple)),
        Actuation(draw(st.floats(0, 0.3))),
    )


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(scenarios())
def test_round_trip(scenario: Scenario) -> None:
    text = write_toml(scenario)
    assert parse_toml(text) == scenario
    assert write_toml(parse_toml(text)) == text


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.dates(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(scenarios(), junk, st.data())
def test_junk_anywhere_is_a_scenario_error_or_fine(scenario: Scenario, bad: Any, data: st.DataObject) -> None:
    from protocol.scenario_file import document_of

    content = document_of(scenario)
    holder: Any = content
    key: Any = data.draw(st.sampled_from(sorted(holder)))
    while isinstance(holder[key], dict | list) and holder[key] and data.draw(st.booleans()):
        holder = holder[key]
        key = data.draw(
            st.sampled_from(sorted(holder) if isinstance(holder, dict) else list(range(len(holder))))
        )
    holder[key] = bad
    try:
        accepted = parse_document(content)
    except ScenarioError as error:
        assume(error.problems)
        return
    assert all(
        math.isfinite(x) for robot in accepted.robots for x in (*robot.start, *robot.goal, robot.radius)
    )


@pytest.mark.parametrize(
    ("setting", "path", "value"),
    [
        ("control.k=80", ("control", "k"), 80),
        ("control.law=orca", ("control", "law"), "orca"),
        ('control.law="orca"', ("control", "law"), "orca"),
        ("robots[1].goal=[0, 0.2]", ("robots", 1, "goal"), [0, 0.2]),
        ("robots[1].goal[0] = 0.2", ("robots", 1, "goal", 0), 0.2),
        ("link.delay=[0.0, 0.3]", ("link", "delay"), [0.0, 0.3]),
        ("process[0].robot=1", ("process", 0, "robot"), 1),
        ("sensing.noise=0.1", ("sensing", 0, "noise"), 0.1),
        ("name=a=b", ("name",), "a=b"),
        ("workspace={radius = 0.5}", ("workspace",), {"radius": 0.5}),
    ],
)
def test_settings(setting: str, path: tuple[str | int, ...], value: object) -> None:
    before = document()
    changed: Any = apply_settings(before, [setting])
    assert before == document()
    for step in path:
        changed = changed[step]
    assert changed == value


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("contrl.k=1", "contrl.k: unknown key; did you mean `control`?"),
        ("control.kay=1", "did you mean `k`"),
        ("robots[2].goal.x=1", "goal"),
        ("robots[9].goal=[0, 0]", "robots has 2 elements"),
        ("robots.goal=[0, 0]", "give a position"),
        ("robots[0].radius[0]=1", "robots[0].radius is not an array"),
        ("robots[0].radius.x=1", "robots[0].radius is not a table"),
        ("robots[-1].radius=1", "a path is made of"),
        (".name=1", "a path is made of"),
        ("control..k=1", "a path is made of"),
        ("control.k", "path=VALUE"),
        ("=3", "a path is made of"),
        ("control.k=[1", "not a TOML value"),
        ("control.k=", "not a TOML value"),
        ("seed=1\nname='x'", "more than one TOML value"),
    ],
)
def test_settings_that_lead_nowhere(setting: str, words: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        apply_settings(document(), [setting, "alsowrong=1"])
    assert words in str(caught.value)
    assert len(caught.value.problems) == 2


def test_a_setting_for_one_of_many_sensing_entries_must_say_which() -> None:
    several = document() | {"sensing": [{}, {}]}
    with pytest.raises(ScenarioError, match=r"sensing\[0\].noise"):
        apply_settings(several, ["sensing.noise=1"])
    assert apply_settings(several, ["sensing[1].noise=1"])["sensing"] == [{}, {"noise": 1}]
    assert apply_settings(document() | {"sensing": {"noise": 1}}, ["sensing.delay=2"])["sensing"] == [
        {"noise": 1, "delay": 2}
    ]


def test_schema_knows_every_table_and_both_forms_of_sensing() -> None:
    schema = json_schema()
    assert schema["required"] == ["robots"]
    assert {"from", "until", "groups"} == schema["$defs"]["Partition"]["properties"].keys()
    assert len(schema["properties"]["sensing"]["anyOf"]) == 2
