"""A law of the user's: found by path, module and entry point, checked, and safe behind lines."""

import math
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from types import ModuleType

import pytest

from agents.law import GuardedLaw, Law, View
from agents.peers.neighbours import Neighbours
from deploy.library.load import load, try_out
from deploy.run.local import LocalFleet
from disknav import Simulation
from protocol.errors import LawError, UsageError
from protocol.messages import Vector
from protocol.scenario.model import Control, Scenario
from protocol.scenario.network import Link

PAGE = Path(__file__).parents[3] / "docs" / "guides" / "law.md"
Write = Callable[[str], str]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes the body of `velocity` of a law to a file, and gives its name."""

    def put(body: str) -> str:
        path = tmp_path / f"law_{len(list(tmp_path.iterdir()))}.py"
        head = "import time\nclass Mine:\n    def __init__(self, scenario, robot): self.robot = robot\n"
        path.write_text(f"{head}    def velocity(self, view): {body}\n")
        return f"{path}:Mine"

    return put


def under(law: str, scenario: str = "head-on", **over: object) -> Scenario:
    base = load(scenario, [f"control.law={law}"])
    return replace(base, **over)  # type: ignore[arg-type]


def a_view() -> View:
    return View(3, (0.0, 0.0), (0.1, 0.0), (0.0, 0.0), Neighbours({}))


def test_a_law_that_inherits_from_the_interface_has_its_slice() -> None:
    """Also where the interface is compiled, and the law is not."""

    class Standing(Law):
        def __init__(self, scenario: Scenario, robot: int) -> None: ...

        def velocity(self, view: View) -> Vector:
            return 0.0, 0.0

    assert Standing(load("head-on"), 1).slice_norm((1.0, 1.0), (4.0, 5.0)) == 10.0


@pytest.mark.slow
def test_the_example_of_the_page_brings_a_swap_home_behind_lines(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (tmp_path / "courtesy.py").write_text(code)
    scenario = under(f"{tmp_path / 'courtesy.py'}:Courtesy", "swap-8", link=Link(delay=0.2))
    one, again = (LocalFleet(scenario).execute() for _ in range(2))
    assert (one["verdict"], one["collisions"]) == ("arrived", 0), one["reason"]
    assert one["trajectory_sha256"] == again["trajectory_sha256"]


def test_a_module_and_an_entry_point_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    under("agents.law.reciprocal:ReciprocalLaw")
    entry = EntryPoint("mine", "agents.law.reciprocal:ReciprocalLaw", "disknav.laws")
    monkeypatch.setattr("agents.law.choice.entry_points", lambda **_: EntryPoints([entry]))
    under("entry-point:mine")


@pytest.mark.parametrize(
    "law", ["nowhere.py:Mine", "no_such_module:Mine", "math:Mine", "math:sqrt", "entry-point:none"]
)
def test_what_is_not_there_or_no_law_is_named_before_anything_starts(law: str) -> None:
    with pytest.raises(UsageError, match=re.escape(law)):
        under(law)


@pytest.mark.parametrize("value", ["None", "0.3", "(1.0,)", "('a', 'b')", "[float('nan'), 0.0]", "1 / 0"])
def test_what_returns_no_velocity_is_refused(write: Write, value: str) -> None:
    said = "ZeroDivisionError" if "/" in value else f"returned {eval(value)}, not two finite numbers"
    with pytest.raises(LawError, match=f"Mine.*tick 0: {re.escape(said)}"):
        under(write(f"return {value}"))


def test_what_takes_longer_than_a_period_is_refused(write: Write) -> None:
    law = write("return time.sleep(0.002) or (0.0, 0.0)")
    scenario = under(law)
    with pytest.raises(UsageError, match="longer than a period"):
        try_out(replace(scenario, time=replace(scenario.time, step=0.001)))


def test_what_is_too_fast_is_slowed_down_and_the_attraction_is_told(write: Write) -> None:
    base = load("head-on")
    law = GuardedLaw(replace(base, control=Control(law=write("return (3, 4)"), k=60.0)), 1)
    assert law.velocity(a_view()) == pytest.approx((0.06, 0.08))
    assert law.slice_norm((0.0, 0.0), (3.0, 4.0)) == pytest.approx(10.0)
    assert math.hypot(*law.velocity(a_view())) <= 0.1 + 1e-12


@pytest.fixture
def failing(write: Write) -> Scenario:
    """Robot 2 of 3 has a law that fails in tick 21."""
    aside = "0.3 * (view.goal[1] - view.position[1])"
    law = write(
        f"return 0.3 * (view.goal[0] - view.position[0]) / (self.robot != 2 or view.tick < 21), {aside}"
    )
    scenario = under(law, "swap-3")
    return replace(scenario, time=replace(scenario.time, limit=4.0))


def test_a_robot_whose_law_fails_stands_and_the_others_go_on(
    failing: Scenario, caplog: pytest.LogCaptureFixture
) -> None:
    simulation = Simulation(failing)
    places = [positions.copy() for positions in simulation]
    assert simulation.verdict == "timeout"
    assert (places[25][1] == places[-1][1]).all()
    assert (places[-1] != places[25]).any(axis=1).tolist() == [True, False, True]
    (said,) = [record.message for record in caplog.records if record.levelname == "WARNING"]
    assert said.startswith("robot-2: ")
    assert "tick 21" in said


@pytest.mark.parametrize(
    ("broken", "error"),
    [
        ("__init__", ValueError),
        ("velocity", ValueError),
        ("velocity", UsageError),
        ("slice_norm", ValueError),
    ],
)
def test_whatever_fails_of_a_law_is_not_called_again(
    monkeypatch: pytest.MonkeyPatch, broken: str, error: type[Exception]
) -> None:
    module = ModuleType("broken_law")

    class Broken:
        calls = 0

        def __init__(self, scenario: Scenario, robot: int) -> None:
            self.fail("__init__")

        def fail(self, where: str) -> None:
            if where == broken:
                Broken.calls += 1
                raise error("sensor gone")

        def velocity(self, view: View) -> tuple[float, float]:
            self.fail("velocity")
            return 0.01, 0.0

        def slice_norm(self, position: tuple[float, float], goal: tuple[float, float]) -> float:
            self.fail("slice_norm")
            return 7.0

    module.Broken = Broken  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "broken_law", module)
    scenario = replace(load("head-on"), control=Control(law="broken_law:Broken", k=60.0))
    law = GuardedLaw(scenario, 1)
    for _ in range(3):
        law.slice_norm((0.0, 0.0), (3.0, 4.0))
        law.velocity(a_view())
    assert law.velocity(a_view()) == (0.0, 0.0)
    assert law.slice_norm((0.0, 0.0), (3.0, 4.0)) == pytest.approx(10.0)
    assert "sensor gone" in law.failure
    assert Broken.calls == 1
