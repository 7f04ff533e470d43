"""The roster: what may follow what, and what each robot is told of it."""

from __future__ import annotations

import pytest

from protocol import messages
from protocol.errors import RosterError
from world.coordinator.roster import Roster

RADII = {1: 0.1, 2: 0.2, 3: 0.1}
PLACES = {1: (0.0, 0.0), 2: (1.0, 0.0), 3: (2.0, 0.0)}
HERE = (5.0, 0.0)


def founded(*there: int) -> Roster:
    roster = Roster()
    roster.found(dict.fromkeys(there, 1), PLACES, RADII)
    return roster


def status(roster: Roster, robot: int) -> str:
    return next(member.status for member in roster.message.members if member.robot == robot)


def test_every_change_is_a_new_version_and_versions_go_on_from_earlier_runs():
    roster = Roster(messages.Roster(7, ()))
    roster.found({1: 4, 2: 4, 3: 4}, PLACES, RADII)
    assert roster.version == 8
    roster.fence(2, PLACES[2])
    roster.admit(2, 5)
    assert roster.version == 10


def test_a_roster_is_told_until_the_present_life_has_acknowledged_it():
    roster = founded(1, 2, 3)
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version)
    assert roster.news(1) is None
    roster.fence(2, PLACES[2])
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version + 1)  # no such version
    assert roster.news(1) == roster.message
    roster.acknowledge(1, 1, roster.version)
    roster.acknowledge(1, 1, roster.version - 1)  # late, and no step back
    assert roster.news(1) is None
    roster.admit(1, 2)
    assert roster.news(1) == roster.message


def test_a_disk_that_was_announced_stands_once_it_is_put_up():
    roster = founded(1, 2, 3)
    roster.announce(9, 0.1, HERE)
    assert [each.robot for each in roster.appearing] == [9]
    roster.put_up(9)
    assert (roster.appearing, status(roster, 9)) == ((), "standing")
    roster.admit(9, 1)
    assert status(roster, 9) == "live"


def test_only_what_stands_can_be_removed_and_it_may_come_back():
    roster = founded(1, 2, 3)
    with pytest.raises(RosterError, match="robot 2 cannot be removed: its disk is live; fence it first"):
        roster.remove(2)
    roster.fence(2, PLACES[2])
    roster.remove(2)
    with pytest.raises(RosterError, match="its disk is gone"):
        roster.admit(2, 2)
    roster.announce(2, 0.3, HERE)
    member = roster.message.members[1]
    assert (member.status, member.incarnation, member.radius) == ("appearing", 1, 0.3)
    roster.withdraw(2)
    assert status(roster, 2) == "gone"


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda roster: roster.admit(1, 1), "life 1 is not newer than 1"),
        (lambda roster: roster.admit(8, 1), "no robot 8 in the roster; there are 1, 2, 3"),
        (lambda roster: roster.announce(1, 0.1, HERE), "robot 1 cannot appear: its disk is live"),
        (lambda roster: roster.withdraw(1), "robot 1 was not announced"),
        (
            lambda roster: (roster.fence(1, HERE), roster.fence(1, HERE)),
            "robot 1 cannot be fenced: its disk is stand",
        ),
    ],
)
def test_what_does_not_fit_is_refused_and_changes_nothing(act, words):
    roster = founded(1, 2, 3)
    with pytest.raises(RosterError, match=words):
        act(roster)
    assert roster.version <= 2
