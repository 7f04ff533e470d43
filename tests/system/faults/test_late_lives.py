"""Lives that come late, or die before the first tick: one trajectory on every bus, and no contact."""

from __future__ import annotations

from dataclasses import replace

import pytest

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.scenario.model import ProcessFault, Scenario
from protocol.scenario.network import Link


def late(*faults: tuple[int, float, str], delay: float = 1.0, seed: int = 1) -> Scenario:
    """A swap in which processes come and go."""
    scenario = load("swap-4", [], seed)
    return replace(
        scenario,
        link=Link(delay=delay),
        process=tuple(ProcessFault(*fault) for fault in faults),
        time=replace(scenario.time, limit=30.0),
    )


# The first life of robot 1 publishes nothing; a new life of another robot never had the initial line with it.
LATE = [
    late((1, 0.0, "kill"), (2, 2.0, "restart"), (1, 10.0, "restart")),
    late((1, 0.0, "pause"), (2, 2.0, "restart"), (1, 10.0, "resume")),
    late((3, 0.0, "restart"), (4, 0.05, "restart"), (3, 0.1, "restart")),
    late((4, 0.0, "kill"), (1, 0.5, "restart"), (2, 0.5, "kill"), (4, 0.9, "restart"), (2, 6.0, "restart")),
]


def trajectory(report: dict) -> str:
    assert report["collisions"] == 0
    assert report["ticks"] > 100
    assert report["faults"]["given_up"] == []  # else another trajectory is right
    return report["trajectory_sha256"]


@pytest.mark.slow
@pytest.mark.parametrize("scenario", LATE)
def test_a_late_life_touches_nobody(scenario: Scenario) -> None:
    trajectory(LocalFleet(scenario).execute())


@pytest.mark.process
@pytest.mark.alone
@pytest.mark.timeout(150)
@pytest.mark.parametrize(("scenario", "transport"), [(LATE[1], "routed"), (LATE[3], "mesh")])
def test_a_late_life_takes_the_same_way_on_every_bus(scenario: Scenario, transport: str) -> None:
    with Fleet(scenario, RunOptions(transport)) as fleet:
        report = fleet.execute()
    assert trajectory(report) == trajectory(LocalFleet(scenario).execute())
