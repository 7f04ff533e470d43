"""Whom a launcher starts again for the next run, however late it hears that a process has ended."""

from __future__ import annotations

from dataclasses import replace

from msgspec.structs import replace as replaced

from deploy.library.load import load
from deploy.run.launcher import Launcher
from deploy.run.local import LocalFleet
from protocol.messages import Clock
from protocol.scenario.model import Order, ProcessFault, Scenario

SWAP = load("swap-4")
WITHOUT = replace(SWAP, orders=(Order(0.3, remove=2),))
AGAIN = [ProcessFault(2, 0.0, "restart")]


class Recorded:
    """Processes of which none has come yet."""

    def knows(self, _robot: int) -> bool:
        return False


def launcher(scenarios: list[Scenario]) -> Launcher:
    return Launcher(scenarios, Recorded())  # type: ignore[arg-type]


def clock(run: int, tick: int = 0, *, founded: bool = False) -> Clock:
    return Clock(tick, 0.05 * tick, (), (), "", run, 0.0, 0.0, "", founded)


def test_who_was_removed_is_started_again_also_if_it_ends_once_the_next_run_gathers() -> None:
    schedule = launcher([WITHOUT, SWAP])
    assert schedule.due(clock(0)) == schedule.due(clock(0, 9, founded=True)) == schedule.due(clock(1)) == []
    schedule.removed(2)
    assert schedule.due(clock(1)) == AGAIN
    assert schedule.due(clock(1)) == []


def test_who_was_removed_is_started_again_also_if_it_was_paused_and_resumed_then() -> None:
    faults = (ProcessFault(2, 0.5, "pause"), ProcessFault(2, 0.6, "resume"))
    schedule = launcher([replace(WITHOUT, process=faults), SWAP])
    assert schedule.due(clock(0)) == []
    schedule.removed(2)
    assert schedule.due(clock(0, 20, founded=True)) == list(faults)
    assert schedule.due(clock(1)) == AGAIN


def test_a_process_whose_robot_is_not_there_is_spared() -> None:
    faults = tuple(ProcessFault(robot, 0.5, "restart") for robot in (2, 3))
    for late in (0, 1, 5):
        schedule = launcher([replace(SWAP, process=faults)])
        seen = replaced(clock(0, 10 + late, founded=True), passed_over=((9, 3), (10, 2)))
        assert schedule.due(seen) == [faults[1]]
        assert schedule.due(seen) == []


def test_what_happened_in_the_last_tick_is_carried_out_though_only_the_verdict_was_heard() -> None:
    faults = tuple(ProcessFault(robot, 0.5 + 0.05 * robot, "kill") for robot in (1, 2))
    schedule = launcher([replace(SWAP, process=faults), SWAP])
    assert schedule.due(clock(0, 9, founded=True)) == []
    ended = replaced(clock(0, 12, founded=True), verdict="timeout")  # tick 11 was the last that was open
    assert schedule.due(ended) == [faults[0]]
    assert schedule.due(ended) == []
    assert schedule.due(clock(1)) == [ProcessFault(1, 0.0, "restart")]


def test_who_is_removed_stays_away_for_the_rest_of_the_run() -> None:
    schedule = launcher([WITHOUT, SWAP])
    assert schedule.due(clock(0)) == []
    schedule.removed(2)
    assert schedule.due(clock(0)) == schedule.due(clock(0, 9, founded=True)) == []
    assert schedule.due(clock(1, 1, founded=True)) == AGAIN  # nothing was heard of its beginning


def test_what_happens_within_a_tick_happens_in_the_order_of_its_times() -> None:
    faults = (ProcessFault(2, 0.52, "resume"), ProcessFault(2, 0.51, "pause"))
    schedule = launcher([replace(SWAP, process=faults)])
    assert schedule.due(clock(0, 20, founded=True)) == [faults[1], faults[0]]
    written, in_order = (
        LocalFleet([replace(SWAP, process=each)]).execute()[0] for each in (faults, tuple(reversed(faults)))
    )
    assert written["verdict"] == "arrived"
    assert written["trajectory_sha256"] == in_order["trajectory_sha256"]
