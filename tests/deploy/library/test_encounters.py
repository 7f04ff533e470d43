"""The library's scenarios with obstacles, each with the property that it is there for."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.theory.surrounded import surrounded, theorem_for
from protocol.scenario.file import validated
from protocol.scenario.model import RobotSpec

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("angle", [0, 60, 150, 270])
def test_in_a_sphere_world_one_robot_arrives_from_everywhere(angle: int) -> None:
    scenario = load("sphere-world")
    assert theorem_for(scenario)[0] == "Koditschek-Rimon"
    start = (0.27 * math.cos(math.radians(angle)), 0.27 * math.sin(math.radians(angle)))
    moved = validated(replace(scenario, robots=(replace(scenario.robots[0], start=start),)))
    report = LocalFleet(moved).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["phi"]["increases"] == 0


@pytest.mark.parametrize("seed", range(2))
def test_beads_keep_their_order(seed: int) -> None:
    """Two that passed each other would have overlapped: the corridor is not as wide as two of them."""
    scenario = load("beads-5", seed=seed)
    (_, low), (_, high) = scenario.workspace.shape.box
    assert high - low < 4.0 * scenario.robots[0].radius
    report = LocalFleet(scenario).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    places = [report["positions"][str(robot)][0] for robot in scenario.ids]
    assert places == sorted(places)


def test_behind_a_box_a_robot_arrives_where_attraction_alone_would_rest() -> None:
    base = load("forest-10")
    alone = replace(base, robots=(RobotSpec(1, 0.15, (-2.0, 0.0), (2.0, 0.0)),), obstacles=base.obstacles[:1])
    box = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
    alone = validated(replace(alone, obstacles=(replace(base.obstacles[0], points=box),)))
    report = LocalFleet(alone).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["nrl"] < 1.2


def test_check_says_which_theorem_does_not_apply_and_why() -> None:
    found = surrounded(load("forest-10"))
    assert found.theorem is None
    assert any("polygon" in reason for reason in found.reasons)
    assert any("several robots" in reason for reason in found.reasons)
    assert found.unreachable == ()
    assert found.to_json()["obstacles"] == 40


def test_check_names_a_goal_that_cannot_be_reached() -> None:
    base = load("beads-2", seed=1)
    wall = replace(
        load("forest-10").obstacles[0], points=((-0.001, -1.0), (0.001, -1.0), (0.001, 1.0), (-0.001, 1.0))
    )
    robot = RobotSpec(1, 0.02, (-0.1, 0.0), (0.1, 0.0))
    found = surrounded(validated(replace(base, robots=(robot,), obstacles=(wall,))))
    assert [each.robot for each in found.unreachable] == [1]
    assert (found.no_way, found.doors) == ((), ())
