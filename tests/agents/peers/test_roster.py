"""The roster as one robot knows it: what is news, and which obstacles are there."""

from agents.peers.roster import KnownRoster
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
