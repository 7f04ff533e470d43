"""The falsifier: a few runs find each planted fault; nothing depends on how busy the machine is."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from deploy.library.instances import parts
from deploy.library.load import load, resolved
from protocol.scenario.file import parse_toml
from protocol.scenario.model import ProcessFault, Scenario
from tests.campaigns import planted
from tests.campaigns.campaign import Dice
from tests.campaigns.falsify import hunt, on_processes
from tests.campaigns.observe import observe
from tests.campaigns.scenarios.draw import drawn

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


@pytest.mark.process
@pytest.mark.timeout(90)
def test_another_trajectory_on_real_processes_is_a_violation() -> None:
    drawings = (drawn(Dice(seed)) for seed in range(99))
    scenario = next(s for s in drawings if s and len(s.robots) == 3 and len(s.process) == 2)
    (found,) = on_processes(scenario, "routed", "0" * 64)
    assert found.kind == "bus"


def _lossy() -> Scenario:
    return load("swap-4", ["link.loss=0.9", "time.limit=10"], 18)


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


BUSY = {
    "fenced": (_fenced, planted.hearing_what_nobody_waited_for),
    "paused": (_paused, planted.hearing_what_nobody_waited_for),
    "parts": (lambda: resolved(parts(2, 3, robots=5, density=0.33)), planted.sizing_as_it_comes),
}


@pytest.mark.slow
@pytest.mark.parametrize("made", [_lossy, *(made for made, _ in BUSY.values())], ids=["lossy", *BUSY])
def test_nothing_follows_from_what_is_heard_first_or_again(made: Callable[[], Scenario]) -> None:
    calm = observe(made()).trajectory
    assert {observe(made(), busy=seed).trajectory for seed in (1, 2)} == {calm}


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize("kind", BUSY)
def test_what_is_heard_first_shows_where_a_fault_lets_it(kind: str) -> None:
    scenario, fault = BUSY[kind][0](), BUSY[kind][1]
    calm = observe(scenario).trajectory
    with planted.plant(fault):
        assert any(observe(scenario, busy=seed).trajectory != calm for seed in range(1, 40))
