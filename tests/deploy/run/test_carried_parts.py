"""Robots that bring parts to their goals, though a robot dies, though its world does."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.errors import ScenarioError
from protocol.scenario.file import validated
from protocol.scenario.model import World
from protocol.scenario.network import Network
from tests.mortal import MortalFleet

SCENARIO = load("parts-4", ["time.limit=60"], 1)


def carriers(fleet: LocalFleet) -> list[int]:
    return [each.carrier for each in fleet.world.world.parts.places if each.carrier]


def carrying() -> tuple[LocalFleet, int]:
    fleet = LocalFleet(SCENARIO)
    while not carriers(fleet):
        assert fleet.step()
    return fleet, carriers(fleet)[0]


def in_place(fleet: LocalFleet) -> bool:
    return not fleet.world.world.parts.pending


def finished(fleet: LocalFleet) -> dict[str, Any]:
    report = fleet.execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert in_place(fleet)
    return report


@pytest.mark.slow
def test_a_part_of_one_that_dies_is_taken_over() -> None:
    fleet, dead = carrying()
    fleet.kill(dead)
    report = finished(fleet)
    assert report["min_clearance"] > 0.0
    members = {each.robot: each for each in fleet.world.world.lives.roster.message.members}
    assert (members[dead].status, members[dead].radius) == ("standing", SCENARIO.spec(dead).radius)


@pytest.mark.slow
def test_a_restarted_world_knows_the_carriers(tmp_path: Path) -> None:
    fleet = MortalFleet(SCENARIO, tmp_path / "checkpoint")
    while not carriers(fleet):
        assert fleet.step()
    before = fleet.world.world.lives
    fleet.kill_world()
    fleet.start_world()
    after = fleet.world.world.lives
    assert after.roster.message.parts == before.roster.message.parts
    assert [after.roster.members[robot].radius for robot in SCENARIO.ids] == [
        before.roster.members[robot].radius for robot in SCENARIO.ids
    ]
    finished(fleet)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"start": (9.0, 0.0)}, "out of the workspace"),
        ({"start": SCENARIO.robots[0].start}, "overlaps the start of robot 1"),
        ({"goal": SCENARIO.parts[1].goal}, "overlaps the goal of part"),
    ],
)
def test_parts_that_cannot_be(change: dict[str, Any], text: str) -> None:
    first, *others = SCENARIO.parts
    with pytest.raises(ScenarioError, match=text):
        validated(replace(SCENARIO, parts=(replace(first, **change), *others)))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"world": World("mujoco")}, 'parts: .*"integrator" only'),
        ({"body": "turtlebot3-burger"}, 'robots.0..body: .* "point"'),
        ({"network": Network("near")}, "network.interest: .*all others"),
    ],
)
def test_what_does_not_go_together_with_parts(change: dict[str, Any], text: str) -> None:
    with pytest.raises(ScenarioError, match=text):
        validated(replace(SCENARIO, **change))
