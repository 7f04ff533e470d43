"""The falsifier: a few runs find each planted fault; nothing depends on how busy the machine is."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import pytest

from deploy.library.instances import parts
from deploy.library.load import load, resolved
from deploy.run.local import LocalFleet
from protocol.bus.bus import Sample
from protocol.codec import encode
from protocol.keys import robot_key
from protocol.messages import State
from protocol.scenario.file import parse_toml
from protocol.scenario.model import ProcessFault, Scenario
from tests.campaigns import planted
from tests.campaigns.campaign import Dice
from tests.campaigns.falsify import hunt, on_processes
from tests.campaigns.observe import Watch, observe, violations
from tests.campaigns.scenarios.draw import drawn
from tests.skipped_waits import skipped_waits

RUNS = 60
KINDS = {  # what a fault shows; contact, wall or contradiction unless mentioned
    planted.drawing_as_it_comes: {"order"},
    planted.failing: {"ZeroDivisionError in command"},
}


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.timeout(600)
@pytest.mark.parametrize("fault", planted.FAULTS, ids=lambda fault: fault.__name__)
def test_every_planted_fault_is_found(fault: planted.Fault) -> None:
    _, violation = hunt(fault, planted.FAULTS[fault], RUNS)
    assert violation.partition(":")[0] in KINDS.get(fault, {"contact", "wall", "contradiction"})


def _report(**changes: object) -> dict[str, Any]:
    return {"contacts": [], "verdict": "timeout", "reason": "", "min_clearance": 0.1, **changes}


def test_what_is_a_violation() -> None:
    touch = {"pair": [1, 2], "from": 0.5, "until": 1.0, "deepest": -0.01}
    wall = {"pair": [0, 2], "from": 0.5, "until": 1.0, "deepest": -0.02}
    assert violations(_report()) == []
    assert violations(_report(verdict="aborted", reason="robot 3 is down for good")) == []
    assert [each.kind for each in violations(_report(contacts=[touch, wall, touch]))] == ["contact", "wall"]
    assert "1 and 2 overlap by 0.01 m" in violations(_report(contacts=[touch]))[0].text
    (gave_up,) = violations(_report(verdict="aborted", reason="no sign of robot 1 within 20 s"))
    assert gave_up.kind == "aborted"
    assert violations(_report(verdict="interrupted"))[0].kind == "endless"


@pytest.mark.process
@pytest.mark.timeout(90)
def test_real_processes_drive_the_same_trajectory() -> None:
    drawings = (drawn(Dice(seed)) for seed in range(99))
    scenario = next(s for s in drawings if s and len(s.robots) == 3 and len(s.process) == 2)
    trajectory = observe(scenario).trajectory
    assert list(on_processes(scenario, "mesh", trajectory)) == []
    (other,) = on_processes(scenario, "routed", "0" * 64)
    assert other.kind == "bus"


@pytest.mark.slow
def test_nothing_follows_from_what_a_busy_machine_has_said_again() -> None:
    scenario = load("swap-4", ["link.loss=0.9", "time.limit=10"], 18)
    calm = observe(scenario).trajectory
    assert {observe(scenario, busy=seed).trajectory for seed in (1, 2)} == {calm}


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
        with LocalFleet(load("swap-4", ["time.limit=1"], 1)) as fleet:
            watch.begin(fleet)
            fleet.network.run(lambda: fleet.world.world.tick == 3)
            began = time.monotonic()
            for tick in range(1000):  # heard late
                state = State(1, 1, tick, None, 0.0, 0.0, 0.0, (0.0, 0.0))
                watch.handle(Sample(robot_key(fleet.run, 1, "state"), encode(state)))
            assert 0.0 < time.monotonic() - began < 10.0  # a holdup for each message would be 35 s


BUSY = {
    "fenced": (_fenced, planted.hearing_what_nobody_waited_for),
    "paused": (_paused, planted.hearing_what_nobody_waited_for),
    "parts": (lambda: resolved(parts(2, 3, robots=5, density=0.33)), planted.sizing_as_it_comes),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", BUSY)
def test_nothing_follows_from_what_is_heard_first(kind: str) -> None:
    scenario = BUSY[kind][0]()
    calm = observe(scenario).trajectory
    assert {observe(scenario, busy=seed).trajectory for seed in range(1, 6)} == {calm}


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("kind", BUSY)
def test_what_is_heard_first_shows_where_a_fault_lets_it(kind: str) -> None:
    scenario, fault = BUSY[kind][0](), BUSY[kind][1]
    calm = observe(scenario).trajectory
    with planted.plant(fault):
        assert any(observe(scenario, busy=seed).trajectory != calm for seed in range(1, 40))
