"""The falsifier: a few runs find each planted fault; nothing depends on how busy the machine is."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from deploy.library.instances import parts
from deploy.library.load import load, resolved
from protocol.scenario.model import ProcessFault, Scenario
from tests.campaigns import planted
from tests.campaigns.campaign import Dice
from tests.campaigns.driver import attempt
from tests.campaigns.falsify import LOCAL, on_processes
from tests.campaigns.observe import observe
from tests.campaigns.scenarios.draw import drawn
from tests.interpreted import Mutant

RUNS = 60
KINDS = {  # what each fault shows first
    "own-error-at-lines": "contact",
    "own-error-at-the-wall": "wall",
    "no-region-no-motion": "contact",
    "measured-then": "contradiction",
    "drawing-as-it-comes": "order",
    "failing": "ZeroDivisionError in command",
}


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.timeout(600)
@pytest.mark.parametrize("fault", planted.FAULTS, ids=lambda fault: fault.rule)
def test_every_planted_fault_is_found(fault: Mutant) -> None:
    def kind_of(seed: int) -> str:
        outcome = attempt(LOCAL, Dice(seed))
        return outcome.said if outcome.violation else ""

    with planted.plant(fault):
        assert fault.hunt(kind_of, RUNS) == KINDS[fault.rule]


@pytest.mark.process
@pytest.mark.timeout(90)
def test_another_trajectory_on_real_processes_is_a_violation() -> None:
    drawings = (drawn(Dice(seed)) for seed in range(99))
    scenario = next(s for s in drawings if s and len(s.robots) == 3 and len(s.process) == 2)
    (found,) = on_processes(scenario, "routed", "0" * 64)
    assert found.kind == "bus"


LATE = "link.delay=[0.0, 0.2]"
FREEZE = ProcessFault(2, 0.4, "pause"), ProcessFault(2, 0.9, "resume")
MADE: dict[str, Callable[[], Scenario]] = {
    "lossy": lambda: load("swap-4", ["link.loss=0.9", "time.limit=10"], 18),
    "near": lambda: load(
        "random-14", ["network.interest=near", "network.reach=0.1", LATE, "link.loss=0.1", "time.limit=4"]
    ),
    "fenced": lambda: replace(
        load("swap-4", ["time.limit=2", "time.fence=0.2", "link.loss=0.3", LATE], 1), process=FREEZE
    ),
    "parts": lambda: resolved(parts(2, 3, robots=5, density=0.33)),
}


@pytest.mark.slow
@pytest.mark.parametrize("made", MADE)
def test_nothing_follows_from_what_is_heard_first_or_again_or_who_joins_first(made: str) -> None:
    scenario = MADE[made]()
    calm = observe(scenario).trajectory
    assert {observe(scenario, scenario.ids[::-1], busy=seed).trajectory for seed in (0, 1)} == {calm}


@pytest.mark.slow
@pytest.mark.campaign
@pytest.mark.parametrize(("made", "fault"), [("fenced", planted.HEARING), ("parts", planted.SIZING)])
def test_what_is_heard_first_shows_where_a_fault_lets_it(made: str, fault: Mutant) -> None:
    scenario = MADE[made]()
    calm = observe(scenario).trajectory
    with planted.plant(fault):
        assert any(observe(scenario, busy=seed).trajectory != calm for seed in range(1, 40))
