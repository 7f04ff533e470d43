"""The roster: what each robot is told of it, version by version, and what speaks against an obstacle."""

from __future__ import annotations

from protocol import messages
from protocol.geometry import Disk
from protocol.messages import Member
from tests.world.driving import two
from world.coordinator.roster import Roster

HERE = (5.0, 0.0)


def filled(version: int = 0) -> Roster:
    roster = Roster(two(), messages.Roster(version, ()))
    for robot in (1, 2, 3):
        roster.put(Member(robot, 1, "live", 0.1))
    return roster


def test_every_change_is_a_new_version_and_versions_go_on_from_earlier_coordinators():
    roster = filled(7)
    assert roster.version == 10
    roster.alter(2, status="standing", position=HERE)
    number = roster.obstacles.announce(Disk(0.0, 0.0, 0.01))
    roster.follow()
    roster.follow()
    assert (roster.version, roster.message.obstacles[0].number) == (12, number)
    again = Roster(two(), roster.message)
    assert again.message == roster.message
    assert again.status(2) == "standing"
    assert [each.robot for each in again.standing] == [2]


def test_a_roster_is_told_until_the_present_life_has_acknowledged_it():
    roster = filled()
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version)
    assert roster.news(1) is None
    roster.alter(2, status="standing", position=HERE)
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version + 1)  # no such version
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version)
    roster.acknowledge(1, 1, roster.version - 1)  # late, and no step back
    assert roster.news(1) is None
    roster.alter(1, incarnation=2)
    assert roster.news(1) == roster.message
