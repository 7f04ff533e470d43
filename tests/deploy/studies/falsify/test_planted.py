"""Planted faults: whatever rule is broken, a small campaign shows it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import pytest

from deploy.library.load import load, resolved
from deploy.library.movers import parts
from deploy.run.local import LocalFleet
from deploy.studies.falsify import trial
from deploy.studies.falsify.campaign import Plan
from deploy.studies.falsify.runs.observe import Watch, observe
from deploy.studies.falsify.runs.skipped_waits import skipped_waits
from deploy.studies.falsify.trial import Shrinking
from deploy.studies.harness.study import Run
from protocol.bus.events import Sample
from protocol.keys import robot_key
from protocol.messages import State
from protocol.scenario.file import parse_toml
from protocol.scenario.model import ProcessFault, Scenario
from protocol.wire.codec import encode
from tests.deploy.studies.falsify import planted

RUNS = 60
Fault = Callable[[planted.Modules, pytest.MonkeyPatch], None]
FAULTS: dict[Fault, tuple[int, set[str]]] = {  # a seed that shows it soon, and what it shows
    planted.half_the_error: (43, {"contact", "wall"}),
    planted.trusting_the_estimate: (0, {"wall"}),
    planted.adopting_blindly: (49, {"contact", "wall"}),
    planted.trusting_initial_lines: (48, {"contact"}),
    planted.forgetting_the_dead: (30, {"contact"}),
    planted.growing_blindly: (27, {"contact"}),
    planted.not_waiting: (0, {"contact"}),
    planted.drawing_as_it_comes: (33, {"order"}),
    planted.failing: (0, {"error"}),
}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_every_planted_fault_is_found(fault: Fault, monkeypatch: pytest.MonkeyPatch) -> None:
    planted.plant(fault, monkeypatch)
    seed, kinds = FAULTS[fault]
    found = planted.first(Plan(seed, RUNS, "local"))
    assert found is not None
    assert found.violation.kind in kinds


@pytest.mark.slow
def test_what_was_found_is_shrunk_to_a_scenario_that_shows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    planted.plant(planted.not_waiting, monkeypatch)
    monkeypatch.setitem(trial.TRIES, "local", 150)
    found = planted.first(Plan(2, RUNS, "local"))
    assert found is not None
    smallest = Shrinking(found.scenario, found.violation, found.first)(Run(2, found.number, "local", ""))
    scenario = resolved(parse_toml(smallest["scenario"]))
    before = [] if smallest["first"] is None else [resolved(parse_toml(smallest["first"]))]
    assert found.violation.kind in {each.kind for each in observe(scenario, before=before).violations}
    assert len(scenario.robots) == 2
    assert len(smallest["scenario"]) < len(found.scenario)
    monkeypatch.undo()
    assert not observe(scenario, before=before).violations


def test_nothing_follows_from_what_a_busy_machine_has_said_again(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load("swap-4", ["link.loss=0.9", "time.limit=10"], 18)
    calm = observe(scenario).trajectory
    assert {observe(scenario, busy=seed).trajectory for seed in (1, 2, 9)} == {calm}
    planted.plant(planted.hearing_all_that_is_said_again, monkeypatch)
    assert any(observe(scenario, busy=seed).trajectory != calm for seed in range(9, 18))


def _fenced() -> Scenario:
    scenario = load("swap-4", ["time.limit=2", "time.fence=0.2", "link.loss=0.3"], 1)
    faults = (ProcessFault(2, 0.4, "pause"), ProcessFault(2, 0.9, "resume"))
    return replace(scenario, process=faults)


def _paused() -> Scenario:
    """For a tick, in which the other one of a pair says for the first time where it is."""
    text = """
        time = { step = 0.05, limit = 0.15 }
        robots = [{ id = 1, radius = 0.09, start = [0.0, -0.1], goal = [0.0, -0.2] }]
        process = [{ robot = 1, at = 0.05, event = "pause" }, { robot = 1, at = 0.1, event = "resume" }]
        [[orders]]
        at = 0.0
        add = { id = 2, radius = 0.04, start = [0.0, 0.1], goal = [0.0, 0.0] }
    """
    return resolved(parse_toml(text))


def test_however_much_a_busy_machine_has_to_catch_up_nobody_is_given_up() -> None:
    with skipped_waits():
        watch = Watch(busy=1)
        with LocalFleet([load("swap-4", ["time.limit=1"], 1)]) as fleet:
            watch.begin(fleet)
            fleet.network.run(lambda: fleet.world.world.tick == 3)
            began = time.monotonic()
            for tick in range(1000):  # heard late
                state = State(1, 1, tick, None, 0.0, 0.0, 0.0, (0.0, 0.0))
                watch.handle(Sample(robot_key(fleet.run, 1, "state"), encode(state)))
            assert 0.0 < time.monotonic() - began < 1.0


@pytest.mark.parametrize(
    ("scenario", "fault"),
    [
        (_fenced(), planted.hearing_what_nobody_waited_for),
        (_paused(), planted.hearing_what_nobody_waited_for),
        pytest.param(
            resolved(parts(2, 3, robots=5, density=0.33)), planted.sizing_as_it_comes, marks=pytest.mark.slow
        ),
    ],
    ids=["fenced", "paused", "parts"],
)
def test_nothing_follows_from_what_is_heard_first(
    scenario: Scenario, fault: Fault, monkeypatch: pytest.MonkeyPatch
) -> None:
    calm = observe(scenario).trajectory
    assert {observe(scenario, busy=seed).trajectory for seed in range(1, 6)} == {calm}
    planted.plant(fault, monkeypatch)
    assert any(observe(scenario, busy=seed).trajectory != calm for seed in range(1, 40))
