"""Who came or left in one run of a fleet, and who takes part in the next."""

from __future__ import annotations

from dataclasses import replace

import pytest

from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol.scenario.model import Order, ProcessFault
from tests.deploy.run.orders.guests import GUEST, GUESTED, SWAP
from tests.skipped_waits import skipped_waits


@pytest.mark.parametrize("again", [False, True], ids=["leaves with the run", "comes in each"])
def test_a_guest_of_one_run_is_none_of_the_next(again: bool) -> None:
    reports = LocalFleet([GUESTED, GUESTED if again else SWAP]).execute()
    assert [report["verdict"] for report in reports] == ["arrived", "arrived"]
    assert [len(report["robots"]) for report in reports] == [5, 5 if again else 4]


def test_a_guest_of_a_later_run_lives_no_life_of_an_earlier_one() -> None:
    """Else a process that missed the end of its run would go on as the other one, by its old lines."""
    fleet = LocalFleet([GUESTED, SWAP, GUESTED])
    lives: list[int] = []
    fleet.network.run(lambda: fleet.world.finished or 7 in fleet.world.world.coordinator.lives.up)
    lives.append(fleet.world.world.coordinator.lives.of[7].incarnation)
    fleet.network.run(lambda: fleet.world.finished or 7 not in fleet.world.world.coordinator.lives.up)
    fleet.network.run(lambda: fleet.world.finished or 7 in fleet.world.world.coordinator.lives.up)
    lives.append(fleet.world.world.coordinator.lives.of[7].incarnation)
    assert lives == [1, 2]
    assert fleet.world._run.oldest[7] == 2  # what the first one said is of an earlier run


def test_a_guest_that_appears_as_the_run_ends_is_told_that_it_is_over() -> None:
    """A robot that was removed while it was paused keeps the world waiting for what it reports."""
    orders = (Order(0.0, add=GUEST), Order(0.0, remove=2))
    pause = (ProcessFault(2, 0.0, "pause"),)
    for limit in range(1, 6):
        time_ = replace(SWAP.time, limit=limit * SWAP.time.step)
        with skipped_waits():
            fleet = LocalFleet([replace(SWAP, time=time_, orders=orders, process=pause)])
            assert [report["verdict"] for report in fleet.execute()] == ["timeout"]


def test_who_followed_a_paused_process_is_there_for_the_next_scenario() -> None:
    """Its robot is removed and added again, and appears as the first scenario ends."""
    again = SWAP.spec(2)
    orders = (Order(0.0, remove=2), Order(0.0, add=again))
    faults = (ProcessFault(2, 0.0, "pause"), ProcessFault(2, 0.0, "restart"))
    for limit in range(1, 8):
        time_ = replace(SWAP.time, limit=limit * SWAP.time.step)
        first = replace(SWAP, time=time_, orders=orders, process=faults)
        with skipped_waits():
            reports = LocalFleet([first, SWAP]).execute()
        assert [report["verdict"] for report in reports] == ["timeout", "arrived"]


@pytest.mark.slow
def test_who_was_removed_takes_part_in_the_next_scenario_that_has_it() -> None:
    without = replace(SWAP, orders=(Order(0.3, remove=2),))
    reports = LocalFleet([without, SWAP]).execute()
    assert [report["robots"] for report in reports] == [[1, 3, 4], [1, 2, 3, 4]]
    with Fleet([without, SWAP], RunOptions("routed")) as fleet:
        found = fleet.execute()
    for report, same in zip(reports, found, strict=True):
        assert report["verdict"] == same["verdict"] == "arrived"
        assert report["trajectory_sha256"] == same["trajectory_sha256"]
