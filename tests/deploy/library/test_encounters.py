"""The library's scenarios with obstacles, each with the property that it is there for."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.theory.facts import plain
from deploy.theory.surrounded import surrounded, theorem_for
from protocol.scenario.file import validated
from protocol.scenario.model import RobotSpec, Sensing
from world.report import result_of

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("angle", [60, 270])
def test_in_a_sphere_world_one_robot_arrives_from_everywhere(angle: int) -> None:
    scenario = load("sphere-world")
    assert theorem_for(scenario)[0] == "Koditschek-Rimon"
    start = (0.27 * math.cos(math.radians(angle)), 0.27 * math.sin(math.radians(angle)))
    moved = validated(replace(scenario, robots=(replace(scenario.robots[0], start=start),)))
    report = LocalFleet(moved).execute()
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert report["phi"]["increases"] == 0


def test_beads_keep_their_order() -> None:
    """Two that passed each other would have overlapped: the corridor is not as wide as two of them."""
    scenario = load("beads-5", seed=1)
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
    assert plain(found)["obstacles"] == 40


SCENARIO = load("in-turn-3")
TICKS = SCENARIO.ticks(1.0)
DISTURBED = (2, 4)  # slots at whose end a standing robot is put 3 mm nearer to the middle


def run() -> tuple[LocalFleet, list[set[int]], list[float]]:
    """The fleet at its end, the robots that moved in each tick, and phi at the start of each."""
    sensing = (Sensing(contradiction="newest"),)  # a robot carried elsewhere believes its measurement
    fleet = LocalFleet(replace(SCENARIO, sensing=sensing))
    world, moved, heights = fleet.world.world, list[set[int]](), list[float]()
    while True:
        before = world.truth
        heights.append(before.phi)
        if not fleet.step():
            return fleet, moved, heights
        after = world.truth.positions
        moved.append(
            {robot for robot, b, a in zip(before.robots, before.positions, after, strict=True) if a != b}
        )
        turn, over = divmod(world.tick, TICKS)
        if over == 0 and turn in DISTURBED:
            positions, index = world.simulation.plant.positions, turn % len(SCENARIO.ids)
            x, y = positions[index]
            away = math.hypot(x, y)
            positions[index] = x - 0.003 * x / away, y - 0.003 * y / away


def test_one_moves_at_a_time_and_phi_descends_though_static_robots_are_disturbed() -> None:
    fleet, moved, heights = run()
    pushed = {turn * TICKS + off for turn in DISTURBED for off in (-1, 0)}
    for tick in set(range(len(moved))) - pushed:
        assert moved[tick] <= {SCENARIO.ids[tick // TICKS % len(SCENARIO.ids)]}
    assert {tick for tick, (b, a) in enumerate(pairwise(heights)) if a > b + 1e-12} <= pushed
    report = result_of(fleet.world.world)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert sum(map(bool, moved)) > 3 * TICKS
