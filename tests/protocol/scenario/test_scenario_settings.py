"""`--set path.to.key=VALUE`: where settings lead, and what is said of those that lead nowhere."""

from typing import Any

import pytest

from protocol.errors import ScenarioError
from protocol.scenario.file import apply_settings
from tests.protocol.scenario.scenario_texts import document


@pytest.mark.parametrize(
    ("setting", "path", "value"),
    [
        ("control.k=80", ("control", "k"), 80),
        ("control.law=reciprocal", ("control", "law"), "reciprocal"),
        ('control.law="reciprocal"', ("control", "law"), "reciprocal"),
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
        ("k=80", "did you mean `control.k`?"),
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
        ("control.k=" + 10_000 * "[", "not a TOML value"),
        ("seed=1\nname='x'", "more than one TOML value"),
    ],
)
def test_settings_that_lead_nowhere(setting: str, words: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        apply_settings(document(), [setting, "alsowrong=1"])
    assert words in str(caught.value)
    assert len(caught.value.problems) == 2


def test_a_setting_that_leads_nowhere_hides_no_other_mistake() -> None:
    with pytest.raises(ScenarioError) as caught:
        apply_settings(document() | {"nam": 1}, ["contrl.k=3", "time.limit=-1"])
    assert [problem.path for problem in caught.value.problems] == ["contrl.k", "nam", "time.limit"]


def test_a_setting_for_one_of_many_sensing_entries_must_say_which() -> None:
    several = document() | {"sensing": [{}, {}]}
    with pytest.raises(ScenarioError, match=r"sensing\[0\].noise"):
        apply_settings(several, ["sensing.noise=1"])
    assert apply_settings(several, ["sensing[1].noise=1"])["sensing"] == [{}, {"noise": 1}]
    assert apply_settings(document() | {"sensing": {"noise": 1}}, ["sensing.delay=2"])["sensing"] == [
        {"noise": 1, "delay": 2}
    ]
