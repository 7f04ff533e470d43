"""What a launcher has to do to processes, and when, however late it hears of it."""

from dataclasses import replace
from unittest.mock import Mock

import pytest
from msgspec.structs import replace as replaced

from deploy.library.load import load
from deploy.run.launcher import Launcher
from deploy.run.local import LocalFleet
from protocol.messages import Clock
from protocol.scenario.model import ProcessFault

SWAP = load("swap-4")


def launcher(*faults: ProcessFault) -> Launcher:
    """Of processes of which none has come yet."""
    return Launcher(replace(SWAP, process=faults), Mock(knows=lambda _: False))


def clock(tick: int = 0, *, founded: bool = False) -> Clock:
    return Clock(tick, 0.05 * tick, (), (), "", 0.0, 0.0, "", founded)


def test_nothing_is_due_before_the_run_has_begun() -> None:
    fault = ProcessFault(2, 0.0, "kill")
    schedule = launcher(fault)
    assert schedule.due(clock()) == []
    assert schedule.due(clock(founded=True)) == [fault]


def test_a_process_whose_robot_is_not_there_is_spared() -> None:
    faults = tuple(ProcessFault(robot, 0.5, "restart") for robot in (2, 3))
    for late in (0, 1, 5):
        schedule = launcher(*faults)
        seen = replaced(clock(10 + late, founded=True), passed_over=((9, 3), (10, 2)))
        assert schedule.due(seen) == [faults[1]]
        assert schedule.due(seen) == []


def test_what_happened_in_the_last_tick_is_carried_out_though_only_the_verdict_was_heard() -> None:
    faults = tuple(ProcessFault(robot, 0.5 + 0.05 * robot, "kill") for robot in (1, 2))
    schedule = launcher(*faults)
    assert schedule.due(clock(9, founded=True)) == []
    ended = replaced(clock(12, founded=True), verdict="timeout")  # tick 11 was the last that was open
    assert schedule.due(ended) == [faults[0]]
    assert schedule.due(ended) == []


@pytest.mark.slow
def test_what_happens_within_a_tick_happens_in_the_order_of_its_times() -> None:
    faults = (ProcessFault(2, 0.52, "resume"), ProcessFault(2, 0.51, "pause"))
    schedule = launcher(*faults)
    assert schedule.due(clock(20, founded=True)) == [faults[1], faults[0]]
    written, in_order = (
        LocalFleet(replace(SWAP, process=each)).execute() for each in (faults, tuple(reversed(faults)))
    )
    assert written["verdict"] == "arrived"
    assert written["trajectory_sha256"] == in_order["trajectory_sha256"]
