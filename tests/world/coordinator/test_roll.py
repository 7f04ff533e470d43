"""The roster: who may be admitted, fenced, announced and removed, and what must be known before."""

from __future__ import annotations

import pytest

from protocol.errors import RosterError
from world.coordinator.roster import Roll

RADII = {1: 0.1, 2: 0.2, 3: 0.1}
PLACES = {1: (0.0, 0.0), 2: (1.0, 0.0), 3: (2.0, 0.0)}
HERE = (5.0, 0.0)


def founded(*there: int) -> Roll:
    roll = Roll()
    roll.found(dict.fromkeys(there, 1), PLACES, RADII)
    return roll


def status(roll: Roll, robot: int) -> str:
    return next(member.status for member in roll.roster.members if member.robot == robot)


def all_acknowledge(roll: Roll, *robots: int, life: int = 1) -> None:
    for robot in robots:
        roll.acknowledge(robot, life, roll.version)


def test_whoever_is_not_there_when_the_run_is_founded_stands_at_its_start():
    members = founded(1, 3).roster.members
    assert [(each.robot, each.status, each.founding) for each in members] == [
        (1, "live", 1),
        (2, "standing", 0),
        (3, "live", 1),
    ]
    assert members[1].position == PLACES[2]


def test_every_change_is_a_new_version_and_versions_go_on_from_earlier_runs():
    roll = Roll(7)
    roll.found({1: 4, 2: 4, 3: 4}, PLACES, RADII)
    assert roll.version == 8
    roll.fence(2, PLACES[2])
    roll.admit(2, 5)
    assert roll.version == 10


def test_a_roster_is_told_until_the_present_life_has_acknowledged_it():
    roll = founded(1, 2, 3)
    assert roll.news(1) == roll.roster
    roll.acknowledge(1, 1, roll.version)
    assert roll.news(1) is None
    roll.fence(2, PLACES[2])
    assert roll.news(1) == roll.roster
    roll.acknowledge(1, 1, roll.version + 1)  # no such version
    assert roll.news(1) == roll.roster
    roll.acknowledge(1, 1, roll.version)
    roll.acknowledge(1, 1, roll.version - 1)  # late, and no step back
    assert roll.news(1) is None
    roll.admit(1, 2)
    assert roll.news(1) == roll.roster


def test_a_later_life_is_no_founding_one():
    roll = founded(1, 2, 3)
    roll.fence(2, (1.5, 0.0))
    roll.admit(2, 2)
    member = roll.roster.members[1]
    assert (member.incarnation, member.status, member.founding, member.position) == (2, "live", 1, None)


def test_a_disk_appears_only_once_everybody_live_keeps_to_its_place():
    roll = founded(1, 2, 3)
    roll.announce(9, 0.1, HERE)
    assert roll.settle() == []
    all_acknowledge(roll, 1, 3)
    assert roll.settle() == []
    all_acknowledge(roll, 2)
    assert roll.settle() == [9]
    assert status(roll, 9) == "standing"
    assert roll.settle() == []
    roll.admit(9, 1)
    assert status(roll, 9) == "live"


def test_an_acknowledgement_of_an_earlier_life_or_version_does_not_count():
    roll = founded(1, 2, 3)
    all_acknowledge(roll, 1, 2, 3)
    roll.announce(9, 0.1, HERE)
    all_acknowledge(roll, 1, 2, 3)
    roll.admit(2, 2)
    all_acknowledge(roll, 1, 3)
    assert roll.settle() == []  # to be admitted with that version is no acknowledgement
    all_acknowledge(roll, 2, life=2)
    assert roll.settle() == [9]


def test_nothing_appears_where_a_disk_stands_and_who_stands_is_not_asked():
    roll = founded(1, 2, 3)
    roll.fence(3, (5.15, 0.0))
    roll.announce(9, 0.1, HERE)
    all_acknowledge(roll, 1, 2)
    assert roll.settle() == []
    roll.remove(3)
    all_acknowledge(roll, 1, 2)
    assert roll.settle() == [9]


def test_only_what_stands_can_be_removed_and_it_may_come_back():
    roll = founded(1, 2, 3)
    with pytest.raises(RosterError, match="robot 2 cannot be removed: its disk is live; fence it first"):
        roll.remove(2)
    roll.fence(2, PLACES[2])
    roll.remove(2)
    with pytest.raises(RosterError, match="its disk is gone"):
        roll.admit(2, 2)
    roll.announce(2, 0.3, HERE)
    member = roll.roster.members[1]
    assert (member.status, member.incarnation, member.radius, member.founding) == ("appearing", 1, 0.3, 0)
    roll.withdraw(2)
    assert status(roll, 2) == "gone"


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda roll: roll.admit(1, 1), "life 1 is not newer than 1"),
        (lambda roll: roll.admit(8, 1), "no robot 8 in the roster; there are 1, 2, 3"),
        (lambda roll: roll.announce(1, 0.1, HERE), "robot 1 cannot appear: its disk is live"),
        (lambda roll: roll.withdraw(1), "robot 1 was not announced"),
        (
            lambda roll: (roll.fence(1, HERE), roll.fence(1, HERE)),
            "robot 1 cannot be fenced: its disk is stand",
        ),
    ],
)
def test_what_does_not_fit_is_refused_and_changes_nothing(act, words):
    roll = founded(1, 2, 3)
    with pytest.raises(RosterError, match=words):
        act(roll)
    assert roll.version <= 2
