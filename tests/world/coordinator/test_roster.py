"""The roster: what each robot is told of it; obstacles that come and go, acknowledged before they appear."""

from dataclasses import replace

import pytest

from protocol import messages
from protocol.messages import Member
from protocol.scenario.model import Obstacle as Listed
from protocol.scenario.model import Operation, RobotSpec, Workspace
from tests.world.driving import advance, joined, obeying, scenario, two
from world.coordinator.roster import RosterDirectory
from world.report import result_of
from world.world import WorldCore


def test_a_roster_is_told_until_the_present_life_has_acknowledged_it():
    roster = RosterDirectory(two(), messages.Roster(0, ()))
    for robot in (1, 2, 3):
        roster.put(Member(robot, 1, "live", 0.1))
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version)
    assert roster.news(1) is None
    roster.alter(2, status="standing", position=(5.0, 0.0))
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version + 1)  # no such version
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version)
    roster.acknowledge(1, 1, roster.version - 1)  # late, and no step back
    assert roster.news(1) is None
    roster.alter(1, incarnation=2)
    assert roster.news(1) == roster.message


BOX = ((0.1, 0.1), (0.2, 0.1), (0.2, 0.2), (0.1, 0.2))
WALL = Listed(points=((0.0, 0.1), (0.01, 0.1), (0.01, 0.2), (0.0, 0.2)))


def world() -> WorldCore:
    """Two robots far apart, a box, and a first tick that is over."""
    setting = replace(
        scenario(((-0.4, 0.0), (0.4, 0.0)), ((0.0, -0.4), (0.0, 0.4))),
        workspace=Workspace(0.6),
        obstacles=(Listed(points=BOX),),
    )
    found = joined(setting)
    advance(found)
    return found


def statuses(found: WorldCore) -> dict[int, str]:
    return {each.number: each.status for each in found.lives.roster.message.obstacles}


def test_an_obstacle_appears_once_everybody_keeps_clear_of_it() -> None:
    found = world()
    reply = found.operate(Operation(place=WALL))
    assert (reply.accepted, reply.number) == (True, 2)
    told = found.open_tick()
    assert statuses(found) == {2: "appearing"}
    assert [each.shape for each in told[1].roster.obstacles] == [WALL.shape]
    found.close_tick()
    told = found.open_tick()
    for robot, clear in ((1, True), (2, False)):
        assert found.accept(obeying(told[robot], clear=clear))
    found.close_tick()
    assert statuses(found) == {2: "appearing"}
    assert WorldCore(found.scenario, found.past).lives.settle()  # where all stand until they have joined
    advance(found)
    assert statuses(found) == {2: "standing"}
    assert found.operate(Operation(add=RobotSpec(3, 0.04, (0.3, 0.3), (0.3, 0.3)))).accepted
    assert WorldCore(found.scenario, found.past).scenario.ids == (1, 2, 3)


def test_what_the_scenario_lists_can_go_and_leaves_the_judge() -> None:
    found = world()
    assert found.operate(Operation(take=1)).accepted
    assert statuses(found) == {1: "gone"}
    assert {each.peer for each in found.open_tick()[1].grants.bindings} == {2}
    for _ in range(4):
        advance(found, {1: (0.1, 0.03)})
    assert not found.operate(Operation(take=1)).accepted
    assert "no obstacle 1" in found.operate(Operation(take=1)).text
    assert result_of(found)["collisions"] == 0


def test_an_obstacle_that_came_is_judged_and_then_forgotten() -> None:
    found = world()
    number = found.operate(Operation(place=Listed(center=(-0.3, 0.0), radius=0.02))).number
    for _ in range(3):
        advance(found)
    for _ in range(10):
        advance(found, {1: (0.1, 0.0)})
    assert [contact["pair"] for contact in result_of(found)["contacts"]] == [[-number, 1]]
    found.operate(Operation(take=number))
    assert found.lives.obstacles.changes == ()


@pytest.mark.parametrize(
    ("order", "words"),
    [
        (
            Listed(points=((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.05, 0.01))),
            "is not convex at point 3, or its sides cross",
        ),
        (Listed(points=((0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.1))), "sides cross"),
        (Listed(center=(0.0, 0.0)), "must be a disk, with `center` and `radius`, or"),
        (Listed(center=(0.0, 0.0), radius=1.0, points=BOX), "must be a disk"),
        (Listed(center=(2.0, 0.0), radius=0.1), "outside of the workspace"),
        (Listed(center=(-0.4, 0.05), radius=0.02), "overlaps robot 1 by 0.01 m"),
    ],
)
def test_a_refusal_says_why_and_changes_nothing(order: Listed, words: str) -> None:
    found = world()
    before = found.past
    reply = found.operate(Operation(place=order))
    assert not reply.accepted
    assert words in reply.text
    assert found.past == before


def test_an_obstacle_on_a_goal_is_accepted_with_a_warning() -> None:
    reply = world().operate(Operation(place=Listed(center=(0.4, 0.05), radius=0.02)))
    assert (reply.accepted, reply.text) == (True, "covers the goal of robot 1")
