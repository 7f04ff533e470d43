"""What a robot knows of its peers: newer lives and ticks win, fenced disks stand until a new life speaks."""

from agents.neighbours import Neighbours
from agents.peer_state import PeerState
from protocol.messages import Down, State


def state(robot: int, incarnation: int, tick: int) -> PeerState:
    return PeerState(State(robot, incarnation, tick, (float(tick), 0.0), 0.0, 1.0, 1.0, (0.0, 0.0)), 1)


def test_only_news_is_taken_over() -> None:
    known = Neighbours([2, 3])
    assert known.hear(state(2, 1, 5))
    assert not known.hear(state(2, 1, 4))
    assert not known.hear(state(2, 1, 5))
    assert known.position(2) == (5.0, 0.0)
    assert known.hear(state(2, 2, 1))
    assert known.position(2) == (1.0, 0.0)
    assert known.position(3) is None


def test_a_fenced_robot_stands_where_the_world_says_until_a_newer_life_speaks() -> None:
    known = Neighbours([2])
    known.hear(state(2, 1, 5))
    down = Down(2, 1, (7.0, 7.0))
    assert known.fence([down]) == [down]
    assert known.fence([down]) == []
    assert known.position(2) == (7.0, 7.0)
    assert known.hear(state(2, 2, 6))
    assert known.position(2) == (6.0, 0.0)
    assert known.fence([down]) == []


def test_strangers_are_not_known() -> None:
    known = Neighbours([2])
    assert known.knows(2)
    assert not known.knows(9)
