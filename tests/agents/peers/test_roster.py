"""The roster as one robot knows it: what is news, which obstacles are there, and when a life is over."""

from agents.peers.roster import KnownRoster, has_ended
from protocol.geometry import Disk
from protocol.messages import Member, PlacedObstacle, Roster

FIRST = Roster(1, (Member(1, 1, "live", 0.1), Member(2, 1, "live", 0.1)))
LATER = Roster(3, (FIRST.members[0], Member(2, 1, "standing", 0.1, (0.5, 0.0))))


def test_only_what_a_newer_roster_says_anew_of_others_is_news() -> None:
    known = KnownRoster(1, {})
    assert known.update(FIRST) == [FIRST.members[1]]
    assert known.update(FIRST) == []
    assert known.update(LATER) == [LATER.members[1]]
    assert known.update(FIRST) == []
    assert known.version == 3
    assert known.update(Roster(4, LATER.members)) == []
    assert known.version == 4


def test_obstacles_are_those_of_the_scenario_but_for_what_came_and_went() -> None:
    listed, came = (
        {1: Disk(0.0, 0.0, 0.1), 2: Disk(1.0, 0.0, 0.1)},
        PlacedObstacle(3, "appearing", ((2.0, 0.0),), 0.2),
    )
    known = KnownRoster(1, listed)
    assert known.shapes == tuple(listed.values())
    known.update(Roster(2, (), (PlacedObstacle(1, "gone"), came)))
    assert known.shapes == (listed[2], came.shape)


def test_a_life_is_over_once_its_disk_stands_or_a_newer_one_is_there() -> None:
    assert not has_ended(FIRST, 1, 1)
    assert has_ended(LATER, 2, 1)
    assert not has_ended(LATER, 2, 2)  # a roster from before this life
    newer = Roster(4, (Member(2, 2, "live", 0.1),))
    assert has_ended(newer, 2, 1)
    assert not has_ended(newer, 2, 2)
    assert not has_ended(newer, 3, 1)
