"""What a robot knows of its peers: newer lives and ticks win, fenced disks stand until a new life speaks."""

from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.messages import Member, Vector


def state(robot: int, incarnation: int, tick: int) -> PeerState:
    return PeerState(robot, incarnation, tick, True, float(tick), 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, radius=0.1)


def standing(robot: int, place: Vector, radius: float = 0.1) -> Member:
    return Member(robot, 1, "standing", radius, place)


def tell(known: Neighbours, member: Member) -> None:
    """What a newer roster says of a peer."""
    known.members = {**known.members, member.robot: member}
    known.on_member(member)


def test_only_news_is_taken_over() -> None:
    known = Neighbours({2: 0.1, 3: 0.1})
    assert known.on_state(state(2, 1, 5))
    assert not known.on_state(state(2, 1, 4))
    assert not known.on_state(state(2, 1, 5))
    assert known.position(2) == (5.0, 0.0)
    tell(known, Member(2, 2, "live", 0.1))
    assert not known.on_state(state(2, 1, 6))
    assert known.on_state(state(2, 2, 1))
    assert known.position(2) == (1.0, 0.0)
    assert known.position(3) is None


def test_a_fenced_robot_stands_where_the_world_says_until_a_newer_life_speaks() -> None:
    known = Neighbours({2: 0.1})
    known.on_state(state(2, 1, 5))
    tell(known, standing(2, (7.0, 7.0)))
    tell(known, Member(2, 2, "live", 0.1))
    assert known.position(2) == (7.0, 7.0)
    assert known.on_state(state(2, 2, 6))
    assert known.position(2) == (6.0, 0.0)
    assert not known.on_state(state(2, 1, 9))  # an earlier life


def test_a_fenced_robot_is_an_obstacle_and_never_moves() -> None:
    known = Neighbours({2: 0.3, 3: 0.2, 4: 0.1})
    for each in (4, 3):
        known.on_state(state(each, 1, each))
    tell(known, standing(3, (7.0, 7.0), 0.2))
    tell(known, standing(2, (8.0, 8.0), 0.3))
    assert [peer.robot for peer in known.moving()] == [4]
    disks = sorted(((disk.x, disk.y, disk.radius, disk.gamma) for disk in known.disks()), reverse=True)
    assert disks == [(8.0, 8.0, 0.3, 0.0), (7.0, 7.0, 0.2, 0.0), (4.0, 0.0, 0.1, 1.0)]


def test_who_is_lost_is_no_obstacle() -> None:
    known = Neighbours({2: 0.1})
    known.on_state(PeerState(2, 1, 5, False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, radius=0.1))
    assert known.disks() == []
    assert known.position(2) is None


def test_who_is_gone_is_forgotten() -> None:
    known = Neighbours({2: 0.1, 3: 0.1})
    known.on_state(state(2, 1, 5))
    tell(known, standing(3, (1.0, 1.0)))
    for robot in (2, 3):
        tell(known, Member(robot, 1, "gone", 0.1))
        assert known.position(robot) is None
    assert known.disks() == known.moving() == []


def test_a_peer_that_the_scenario_did_not_name() -> None:
    known = Neighbours({2: 0.1})
    tell(known, Member(7, 0, "appearing", 0.3, (1.0, 1.0)))
    assert [(disk.x, disk.radius) for disk in known.disks()] == [(1.0, 0.3)]
    tell(known, Member(7, 1, "live", 0.3))
    assert known.on_state(state(7, 1, 4))
    assert [peer.robot for peer in known.moving()] == [7]
    tell(known, Member(7, 1, "gone", 0.3))
    assert not known.on_state(state(7, 1, 5))  # it was late
    assert known.disks() == []


def test_only_robots_that_are_attended_or_stand_are_kept() -> None:
    known = Neighbours({2: 0.1, 3: 0.2, 4: 0.1})
    for member in (Member(2, 1, "live", 0.1), standing(3, (7.0, 7.0), 0.2), Member(4, 1, "live", 0.1)):
        tell(known, member)
    for robot in (2, 4):
        assert known.on_state(state(robot, 1, 5))
    known.attend([4])
    assert [(disk.x, disk.radius) for disk in known.disks()] == [(7.0, 0.2), (5.0, 0.1)]
