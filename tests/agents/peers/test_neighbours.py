"""What one robot knows of the others, by their States and the roster."""

from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.messages import Member, Vector


def state(robot: int, incarnation: int, tick: int) -> PeerState:
    return PeerState(robot, incarnation, tick, True, float(tick), 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, radius=0.1)


def standing(robot: int, place: Vector, radius: float = 0.1) -> Member:
    return Member(robot, 1, "standing", radius, place)


def tell(known: Neighbours, member: Member) -> None:
    """What a newer roster says of a peer."""
    known.lives = {**known.lives, member.robot: member.incarnation if member.status == "live" else -1}
    known.on_member(member)


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
    for robot in (2, 3):
        tell(known, Member(robot, 1, "gone", 0.1))
        assert known.position(robot) is None
    assert known.disks() == known.moving() == []


def test_a_peer_that_the_scenario_did_not_name() -> None:
    known = Neighbours({2: 0.1})
    tell(known, Member(7, 0, "appearing", 0.3, (1.0, 1.0)))
    assert [(disk.x, disk.radius) for disk in known.disks()] == [(1.0, 0.3)]
    tell(known, Member(7, 1, "live", 0.3))
    assert known.on_state(state(7, 1, 4), 9)
    assert [peer.robot for peer in known.moving()] == [7]
    tell(known, Member(7, 1, "gone", 0.3))
    assert not known.on_state(state(7, 1, 5), 9)  # it was late
    assert known.disks() == []


def test_in_which_order_peers_are_heard_first_changes_nothing() -> None:
    known = Neighbours({2: 0.1, 3: 0.1, 4: 0.1})
    for robot in (4, 2, 3):
        assert known.on_state(state(robot, 1, 5), 5)
    assert [each.robot for each in known.moving()] == [2, 3, 4]
