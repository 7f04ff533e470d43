"""What one robot knows of the others, by their States and the roster."""

import pytest

from agents.peers.neighbours import Neighbours, PeerInbox
from agents.peers.state import PeerState
from deploy.library.load import load
from protocol.geometry import Disk
from protocol.messages import Member, PlacedObstacle, Roster, Tick, Vector


def state(robot: int, incarnation: int, tick: int) -> PeerState:
    return PeerState(robot, incarnation, tick, True, float(tick), 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, radius=0.1)


def standing(robot: int, place: Vector) -> Member:
    return Member(robot, 1, "standing", 0.1, place)


def tell(known: Neighbours, member: Member) -> None:
    """What a newer roster says of a peer."""
    members = {**known.members, member.robot: member}
    known.on_roster(Roster(known.version + 1, tuple(members.values())))


def test_only_news_is_taken_over() -> None:
    known = Neighbours({2: 0.1, 3: 0.1})
    assert known.on_state(state(2, 1, 5), 9)
    assert not known.on_state(state(2, 1, 4), 9)
    assert not known.on_state(state(2, 1, 5), 9)
    assert known.position(2) == (5.0, 0.0)
    tell(known, Member(2, 2, "live", 0.1))
    assert not known.on_state(state(2, 1, 6), 9)
    assert known.on_state(state(2, 2, 1), 9)
    assert known.position(2) == (1.0, 0.0)
    assert known.position(3) is None


def test_a_fenced_robot_stands_where_the_world_says_until_a_newer_life_speaks() -> None:
    known = Neighbours({2: 0.1})
    known.on_state(state(2, 1, 5), 9)
    tell(known, standing(2, (7.0, 7.0)))
    tell(known, Member(2, 2, "live", 0.1))
    assert known.position(2) == (7.0, 7.0)
    assert known.on_state(state(2, 2, 6), 9)
    assert known.position(2) == (6.0, 0.0)
    assert not known.on_state(state(2, 1, 9), 9)  # an earlier life


def test_a_robot_that_is_gone_is_forgotten() -> None:
    known = Neighbours({2: 0.1, 3: 0.1})
    known.on_state(state(2, 1, 5), 9)
    tell(known, standing(3, (1.0, 1.0)))
    assert [(disk.x, disk.gamma) for disk in known.disks()] == [(5.0, 1.0), (1.0, 0.0)]
    for robot in (2, 3):
        tell(known, Member(robot, 1, "gone", 0.1))
        assert known.position(robot) is None
    assert known.disks() == known.moving() == []


def test_a_peer_that_the_scenario_did_not_name() -> None:
    known = Neighbours({2: 0.1})
    tell(known, Member(7, 0, "appearing", 0.3, (1.0, 1.0)))
    lost = state(2, 1, 3)
    lost.placed = False
    assert known.on_state(lost, 9)
    assert [(disk.x, disk.radius) for disk in known.disks()] == [(1.0, 0.3)]
    tell(known, Member(7, 1, "live", 0.3))
    assert known.on_state(state(7, 1, 4), 9)
    assert [peer.robot for peer in known.moving()] == [2, 7]
    tell(known, Member(7, 1, "gone", 0.3))
    assert not known.on_state(state(7, 1, 5), 9)  # it was late
    assert known.disks() == []


def test_a_repeated_state_is_no_news_even_of_a_peer_that_was_dropped() -> None:
    heard: list[PeerState] = []
    inbox = PeerInbox(load("swap-2"), 1, heard.append, lockstep=True)
    inbox.open(Tick(1, 1, 3, (1, 2)))
    inbox.on_state(state(2, 1, 3))
    inbox.close()
    inbox.neighbours.attend(())
    inbox.on_state(state(2, 1, 3))
    inbox.open(Tick(1, 1, 4, (1, 2)))
    assert (len(heard), inbox.neighbours.position(2)) == (1, None)


def test_only_a_newer_roster_counts() -> None:
    known = Neighbours({2: 0.1})
    known.on_roster(Roster(3, (standing(2, (7.0, 7.0)),)))
    known.on_roster(Roster(3, (standing(2, (8.0, 8.0)),)))
    known.on_roster(Roster(2, (Member(2, 1, "gone", 0.1),)))
    assert known.position(2) == (7.0, 7.0)
    assert known.version == 3
    known.on_roster(Roster(4, (Member(2, 1, "gone", 0.1),)))
    assert known.position(2) is None


def test_the_own_entry_of_a_roster_is_no_peer() -> None:
    known = Neighbours({2: 0.1}, robot=1)
    known.on_roster(Roster(1, (standing(1, (7.0, 7.0)), standing(2, (8.0, 8.0)))))
    assert list(known.standing) == [2]
    assert list(known.members) == [1, 2]


def test_obstacles_are_those_of_the_scenario_but_for_what_came_and_went() -> None:
    listed = {1: Disk(0.0, 0.0, 0.1), 2: Disk(1.0, 0.0, 0.1)}
    came = PlacedObstacle(3, "appearing", ((2.0, 0.0),), 0.2)
    known = Neighbours({}, listed=listed)
    assert known.shapes == tuple(listed.values())
    known.on_roster(Roster(2, (), (PlacedObstacle(1, "gone"), came)))
    assert known.shapes == (listed[2], came.shape)


@pytest.mark.parametrize("lockstep", [True, False])
def test_a_state_counts_from_its_tick_on_and_of_a_missed_tick_only_in_real_time(lockstep: bool) -> None:
    accepted: list[PeerState] = []
    inbox = PeerInbox(load("swap-2"), 1, accepted.append, lockstep=lockstep)
    inbox.open(Tick(1, 1, 4, (1, 2)))
    inbox.close()
    inbox.on_state(state(2, 1, 4))
    inbox.on_state(state(2, 1, 5))
    assert accepted == [], "a Command is in force"
    inbox.open(Tick(1, 1, 6, (1, 2)))
    inbox.on_state(state(2, 1, 5))
    missed = [] if lockstep else [4, 5]
    assert [each.tick for each in accepted] == missed
    assert (inbox.missing, inbox.complete) == ([2], not lockstep)
    inbox.on_state(state(2, 1, 7))
    inbox.close()
    inbox.open(Tick(1, 1, 7, (1, 2)))
    assert [each.tick for each in accepted] == missed
    inbox.close()
    assert [each.tick for each in accepted] == [*missed, 7]
