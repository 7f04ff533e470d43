"""The library: valid, deterministic, and as tight as the paper says."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from deploy.cli.scenario import app
from deploy.library.encounters import swap
from deploy.library.instances import GOAL_SETS, figure_3, random_instance, random_starts
from deploy.library.load import build, catalogue, generate, load
from protocol.errors import ScenarioError, UsageError
from protocol.scenario.checks import doubts
from protocol.scenario.file import parse_toml, validated, write_toml
from protocol.scenario.model import Scenario
from world.judge import measures
from world.judge.clearance import Disks
from world.judge.measures import Goals

NAMES = [entry.name for entry in catalogue() if not entry.name.endswith("-N")]
NONE = ["swap-1", "swap-1001", "random-0", "random-1001", "blocks-6", "parts-41"]
NUMBERED = ["swap-2", "swap-3", "swap-10", "swap-60", "random-1", "random-2", "random-40"]


def gap(scenario: Scenario, start: bool) -> float:
    disks = [(robot.start if start else robot.goal, robot.radius) for robot in scenario.robots]
    wall = min(-scenario.workspace.shape.distance(*p) - r for p, r in disks)
    pairs = [math.dist(p, q) - r - s for n, (p, r) in enumerate(disks) for q, s in disks[:n]]
    return min([wall, *pairs])


@pytest.mark.parametrize("name", NAMES + NUMBERED)
def test_every_name_is_valid_and_survives_a_file(name: str) -> None:
    scenario = build(name)
    assert scenario.name == name
    assert parse_toml(write_toml(scenario)) == validated(scenario) == scenario
    assert min(gap(scenario, True), gap(scenario, False)) > 0.003
    assert not list(doubts(scenario))


@pytest.mark.parametrize("setting", ["time.step=50", "control.speed=100", "sensing.noise=1"])
def test_a_value_that_is_hardly_meant_is_warned_of(setting: str, caplog: pytest.LogCaptureFixture) -> None:
    load("figure-1", [setting])
    assert setting.partition(".")[0] in caplog.text


@pytest.mark.parametrize(
    ("letter", "tight"), [("a", 2.44), ("b", 2.63), ("c", 2.87), ("d", 3.30), ("e", 3.45)]
)
def test_goal_sets_have_the_papers_tightness(letter: str, tight: float) -> None:
    scenario = figure_3(letter)
    assert measures.tight(Disks.of(scenario), Goals.of(scenario)) == pytest.approx(tight, abs=0.02)
    assert scenario.workspace.radius == 0.30
    assert [robot.goal for robot in scenario.robots] == list(GOAL_SETS[letter])


def test_seeds_determine_starts() -> None:
    assert figure_3("d", 4) == figure_3("d", 4)
    assert figure_3("d", 4).robots != figure_3("d", 5).robots
    assert len({random_starts([0.04] * 6, 0.3, seed)[0] for seed in range(40)}) == 40


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.integers(1, 40), st.integers(0, 2**63 - 1), st.floats(0.01, 0.35), st.floats(0.0, 0.5))
def test_random_instances_always_exist(count: int, seed: int, density: float, unequal: float) -> None:
    scenario = random_instance(count, seed, density=density, unequal=unequal)
    radii = [robot.radius for robot in scenario.robots]
    assert len(radii) == count
    assert min(gap(scenario, True), gap(scenario, False)) > 0.04 * min(radii)
    filled = sum(r * r for r in radii) / scenario.workspace.radius**2
    assert filled <= density + 1e-9
    if count > 3:
        assert filled == pytest.approx(density, rel=1e-4)
    assert max(radii) - min(radii) <= 0.08 * unequal + 1e-4


@pytest.mark.parametrize(
    "call",
    [
        lambda: random_instance(5, 1, density=0.36),
        lambda: random_instance(5, 1, density=0.0),
        lambda: random_instance(5, 1, unequal=0.6),
        lambda: random_starts([0.04] * 30, 0.2, 1),
        lambda: random_starts([0.3], 0.3, 1),
        lambda: swap(5, 0.02),
        lambda: swap(5, -0.1),
        lambda: figure_3("f"),
        *(partial(build, name) for name in NONE),
        lambda: generate("swap", 0, {"robots": 1}),
        lambda: generate("swap", 0, {"density": 0.1}),
        lambda: generate("figure-1", 0, {"count": 3}),
    ],
)
def test_what_cannot_be_made_is_refused(call: Callable[[], object]) -> None:
    with pytest.raises(UsageError):
        call()


@pytest.mark.parametrize(
    "names", ["figure1 figure-1", "figure-3f figure-3", "headon head-on", "? swap-N", "swap-N swap-4"]
)
def test_an_unknown_name_is_answered_with_near_ones(names: str) -> None:
    name, near = names.split()
    with pytest.raises(UsageError, match=near):
        load(name)


def test_load_resolves_k_and_applies_settings() -> None:
    scenario = load("swap-12", ["time.limit=5", "robots[0].radius=0.02"])
    assert isinstance(scenario.control.k, float)
    assert scenario.time.limit == 5.0
    assert scenario.robots[0].radius == 0.02
    assert load("swap-12", ["control.k=80"]).k == 80.0


def test_load_reads_files_and_lays_the_seed_over_them(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(write_toml(figure_3("a", 3)))
    assert load(str(path)) == figure_3("a", 3)
    assert load(str(path), seed=9).seed == 9
    assert load(str(path), seed=9).robots == figure_3("a", 3).robots
    assert load("figure-3a", seed=9) == figure_3("a", 9)
    for missing in ("other.toml", "figure-1.tml"):
        with pytest.raises(UsageError, match="no scenario file"):
            load(missing)


def test_commands_print_what_can_be_read_back(tmp_path: Path) -> None:
    runner = CliRunner()
    listed = runner.invoke(app, ["list"]).stdout
    assert all(name in listed for name in [*NAMES, "swap-N", "random-N"])
    assert parse_toml(runner.invoke(app, ["show", "figure-3d", "--seed", "4"]).stdout) == figure_3("d", 4)
    target = tmp_path / "new.toml"
    made = runner.invoke(
        app, ["new", "swap", "-n", "7", "--jitter", "0.01", "--seed", "2", "-o", str(target)]
    )
    assert made.exit_code == 0
    assert parse_toml(target.read_text()) == swap(7, 0.01, 2)
    assert '"robots"' in runner.invoke(app, ["schema"]).stdout
    failed = runner.invoke(app, ["show", "figure-1", "--set", "control.kk=3"])
    assert isinstance(failed.exception, ScenarioError)
