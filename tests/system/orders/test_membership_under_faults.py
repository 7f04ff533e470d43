"""Robots that come and go while processes fail, the world's among them."""

from __future__ import annotations

from pathlib import Path

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.scenario.file import parse_toml
from tests.campaigns.observe import observe
from tests.system.orders.guests import GUEST, SWAP, step, to_be
from tests.system.orders.turnover import Turnover, asked
from world.report import result_of
from world.shell.checkpoint import Checkpoint


def test_no_fault_that_the_world_passes_over_ends_the_process_of_the_next_robot() -> None:
    """However late a launcher gets to the first: robot 2 is not there, and its next process comes."""
    text = """
        time = { step = 0.05, limit = 0.3 }
        workspace = { radius = 3.0 }
        process = [{ robot = 2, at = 0.04, event = "restart" }, { robot = 2, at = 0.053, event = "restart" }]
        robots = [
            { id = 1, radius = 0.3, start = [0.0, 1.0], goal = [0.0, 0.0] },
            { id = 2, radius = 0.3, start = [0.0, 0.0], goal = [0.0, -1.0] },
        ]
        [[orders]]
        at = 0.0
        remove = 2
        [[orders]]
        at = 0.05
        add = { id = 2, radius = 0.09, start = [0.0, 0.0], goal = [0.0, 1.0] }
    """
    scenario = resolved(parse_toml(text))
    calm = observe(scenario)
    assert calm.report is not None
    assert calm.report["faults"]["given_up"] == []
    assert [fault["tick"] for fault in calm.report["faults"]["process"]] == [2]
    assert {observe(scenario, busy=seed).trajectory for seed in range(1, 6)} == {calm.trajectory}


@pytest.mark.parametrize("event", ["restart", "kill", "resume"])
def test_a_newcomer_that_is_paused_has_no_process_before_it_may_join(event: str) -> None:
    """One that were started, and waited, might be ended by the next fault, or join just before."""
    text = f"""
        time = {{ step = 0.05, limit = 1.0 }}
        workspace = {{ radius = 3.0 }}
        process = [{{ robot = 2, at = 0.05, event = "pause" }}, {{ robot = 2, at = 0.25, event = "{event}" }}]
        robots = [
            {{ id = 1, radius = 0.3, start = [0.0, -1.0], goal = [0.0, -1.5] }},
            {{ id = 3, radius = 0.3, start = [1.0, -1.0], goal = [1.0, -1.5] }},
        ]
        [[orders]]
        at = 0.0
        add = {{ id = 2, radius = 0.09, start = [0.0, 0.0], goal = [0.0, 1.0] }}
    """
    scenario = resolved(parse_toml(text))
    calm = observe(scenario)
    assert calm.report is not None
    assert calm.report["faults"]["given_up"] == []
    assert {observe(scenario, busy=seed).trajectory for seed in range(1, 4)} == {calm.trajectory}


def test_a_restarted_world_knows_who_came_and_went(tmp_path: Path) -> None:
    Checkpoint.create(tmp_path / "checkpoint")
    fleet = LocalFleet(SWAP, checkpoint=tmp_path / "checkpoint")
    step(fleet, 10)
    assert asked(fleet, {"add": GUEST}).accepted
    to_be(fleet, 7, "live")
    assert asked(fleet, {"remove": 1}).accepted
    step(fleet, 5)
    before = fleet.world.world
    fleet.kill_world()
    fleet.start_world()
    after = fleet.world.world
    assert after.truth == before.truth
    then, now = (
        before.coordinator.lives.roster.message.members,
        after.coordinator.lives.roster.message.members,
    )
    for one, other in zip(then, now, strict=True):
        assert (one.robot, one.incarnation, one.radius) == (other.robot, other.incarnation, other.radius)
    report = fleet.execute()
    assert (report["verdict"], report["collisions"], report["robots"]) == ("arrived", 0, [2, 3, 4, 7])


@pytest.mark.parametrize("removed", [False, True], ids=["announced robots", "removed robots"])
def test_a_restarted_world_can_tell_everybody_whom_its_roster_names(tmp_path: Path, removed: bool) -> None:
    Checkpoint.create(tmp_path / "checkpoint")
    fleet = LocalFleet(SWAP, checkpoint=tmp_path / "checkpoint")
    step(fleet, 10)
    assert asked(fleet, {"add": GUEST}).accepted
    if removed:
        to_be(fleet, 7, "live")
        assert asked(fleet, {"remove": 7}).accepted
        step(fleet, 5)
    fleet.kill_world()
    fleet.start_world()
    report = fleet.execute()
    there = [1, 2, 3, 4] if removed else [1, 2, 3, 4, 7]
    assert (report["verdict"], report["collisions"], report["robots"]) == ("arrived", 0, there)


@pytest.mark.slow
def test_comings_and_goings_under_faults() -> None:
    turnover = Turnover(0)
    turnover.run(600)
    assert result_of(turnover.fleet.world.world)["collisions"] == 0
    assert turnover.changes >= 20
    assert turnover.settles(2400)
