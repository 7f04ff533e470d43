"""Robots that bring parts to their goals, though a robot dies."""

from dataclasses import replace
from typing import Any

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.errors import ScenarioError
from protocol.scenario.file import validated
from protocol.scenario.model import World
from protocol.scenario.network import Network

SCENARIO = load("parts-4", ["time.limit=60"], 1)


@pytest.mark.slow
def test_a_part_of_one_that_dies_is_taken_over() -> None:
    fleet = LocalFleet(SCENARIO)
    parts = fleet.world.world.parts
    while not (carriers := [each.carrier for each in parts.places if each.carrier]):
        assert fleet.step()
    fleet.kill(dead := carriers[0])
    report = fleet.execute()
    assert (report["verdict"], report["collisions"], parts.pending) == ("arrived", 0, False)
    assert report["min_clearance"] > 0.0
    members = {each.robot: each for each in fleet.world.world.lives.roster.message.members}
    assert (members[dead].status, members[dead].radius) == ("standing", SCENARIO.spec(dead).radius)


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
