"""Statuses of robots and of the run in a view: which are alarms, and which are not."""

from __future__ import annotations

import msgspec
import pytest
from rich.console import Console, RenderableType

from deploy.telemetry.monitor import snapshot as telling
from deploy.telemetry.monitor.terminal import table
from protocol.messages import Errand, GoalStatus, Standing
from protocol.operations import Steering
from tests.deploy.telemetry.monitor.view.heard import (
    SCENARIO,
    clock,
    health,
    rows,
    run_to,
    statuses,
    truth,
    view,
)


@pytest.mark.parametrize(
    ("errand", "said"), [("arrived", "at goal"), ("cancelled", "cancelled"), ("given up", "given up")]
)
def test_a_robot_that_stays_says_why(errand: Errand, said: str) -> None:
    it = view()
    run_to(it, 1, 0.0)
    it.on_message(GoalStatus(1, 1, 1, errand, (it.robots[1].position[0], 0.0)), 0.0)
    assert statuses(it, 0.0) == [said, "under way", "under way"]


def test_a_dead_robot_is_an_alarm_at_once_and_the_others_are_not() -> None:
    it = view()
    run_to(it, 1, 0.0)
    it.present(2, False)
    assert statuses(it, 0.0) == ["under way", "dead", "under way"]
    assert [row["alarm"] for row in rows(it, 0.0).values()] == [False, True, False]


def test_a_fenced_robot_is_an_alarm_until_it_takes_part_again() -> None:
    it = view()
    down = (Standing(3, 1, (0.1, 0.0)),)
    it.on_message(clock(5, active=(1, 2), down=down), 0.0)
    assert statuses(it, 0.0)[2] == "fenced"
    it.on_message(clock(9, active=(1, 2, 3), down=down), 0.1)
    assert statuses(it, 0.1)[2] != "fenced"


def test_a_robot_that_falls_behind_its_peers_is_silent_before_its_token_goes() -> None:
    it = view(lockstep=False)
    for tick in range(1, 60):
        now = tick * 0.05
        run_to(it, tick, now)
        for robot in (1, 2):
            it.on_message(health(robot, tick, heard=((3, min(tick, 10)),)), now)
    assert statuses(it, 59 * 0.05) == ["under way", "under way", "silent"]
    assert rows(it, 59 * 0.05)[3]["age_ticks"] == 49
    assert rows(it, 59 * 0.05)[3]["age"] == pytest.approx(49 * 0.05, abs=0.06)


def test_in_a_pause_nobody_is_silent() -> None:
    it = view()
    run_to(it, 20, 1.0)
    it.steering = Steering(paused=True)
    assert telling.snapshot(it, 60.0)["phase"] == "paused"
    assert statuses(it, 60.0) == ["under way"] * 3


def test_after_the_verdict_everybody_leaves_and_that_is_no_alarm() -> None:
    it = view()
    it.on_message(truth(7, y=0.1), 0.0)
    it.on_message(clock(7, verdict="arrived"), 0.0)
    for robot in (1, 2, 3, None):
        it.present(robot, False)
    frame = telling.snapshot(it, 5.0)
    assert (frame["phase"], frame["verdict"]) == ("ended", "arrived")
    assert statuses(it, 5.0) == ["at goal"] * 3


def test_the_reason_of_the_verdict_is_told_until_another_scenario_begins() -> None:
    it = view()
    it.on_message(
        msgspec.structs.replace(clock(7, verdict="deadlock"), reason="no robot moved for 10 s"), 0.0
    )
    frame = telling.snapshot(it, 0.0)
    assert frame["reason"] == "no robot moved for 10 s"
    assert "no robot moved for 10 s" in _printed(table(frame))
    it.begin(SCENARIO, True)
    assert telling.snapshot(it, 0.0)["reason"] == ""


def _printed(what: RenderableType) -> str:
    console = Console(width=200)
    with console.capture() as capture:
        console.print(what)
    return capture.get()


def test_a_world_that_goes_without_a_verdict_is_lost() -> None:
    it = view()
    run_to(it, 2, 0.0)
    it.present(None, False)
    assert telling.snapshot(it, 0.0)["phase"] == "lost"
