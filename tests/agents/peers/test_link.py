"""Injected link faults: when a State is heard, how often, and by whom."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from agents.peers.link import Link
from agents.peers.state import PeerState
from protocol.scenario.model import Link as LinkFaults
from protocol.scenario.model import Partition, RobotSpec, Scenario

ROBOTS = tuple(RobotSpec(i, 0.01, (0.05 * i, 0.0), (0.05 * i, 0.1)) for i in (1, 2, 3, 4))
SCENARIO = Scenario(robots=ROBOTS, seed=5)


def state(robot: int, tick: int, incarnation: int = 1) -> PeerState:
    return PeerState(robot, incarnation, tick, True, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, radius=0.1)


def heard(faults: LinkFaults, states: list[PeerState], until: int = 200) -> list[list[tuple[int, int]]]:
    """What robot 1 hears at each tick, as (robot, tick of the State)."""
    link = Link(replace(SCENARIO, link=faults), 1)
    for each in states:
        link.put(each)
    return [[(s.robot, s.tick) for s in link.take(tick)] for tick in range(until)]


def test_an_ideal_link_delivers_each_state_once_at_its_tick() -> None:
    ticks = heard(LinkFaults(), [state(2, 3), state(3, 3), state(2, 4)])
    assert [(tick, entry) for tick, entry in enumerate(ticks) if entry] == [
        (3, [(2, 3), (3, 3)]),
        (4, [(2, 4)]),
    ]


def test_a_delay_takes_effect_at_the_first_tick_at_or_after_it() -> None:
    assert heard(LinkFaults(delay=0.11), [state(2, 0)])[3] == [(2, 0)]
    assert heard(LinkFaults(delay=0.10), [state(2, 0)])[2] == [(2, 0)]


def test_loss_and_duplication_happen_as_often_as_stated() -> None:
    states = [state(2, tick) for tick in range(4000)]
    lost = heard(LinkFaults(loss=0.3), states, 4000)
    assert 0.65 < sum(map(len, lost)) / 4000 < 0.75
    doubled = heard(LinkFaults(duplicate=0.2, delay=(0.0, 0.2)), states, 4100)
    assert 1.15 < sum(map(len, doubled)) / 4000 < 1.25


def test_a_partition_separates_groups_while_it_lasts() -> None:
    faults = LinkFaults(partition=(Partition(1.0, 2.0, ((1, 3), (2, 4))),))
    states = [state(robot, tick) for tick in (19, 20, 39, 40) for robot in (2, 3)]
    assert [entry for tick in heard(faults, states) for entry in tick] == [
        (2, 19), (3, 19), (3, 20), (3, 39), (2, 40), (3, 40),
    ]  # fmt: skip


@given(st.randoms(use_true_random=False), st.integers(0, 2**63 - 1))
def test_the_order_of_arrival_changes_nothing(random, seed: int) -> None:
    faults = LinkFaults(delay=(0.0, 1.0), jitter=0.3, loss=0.3, duplicate=0.3)
    states = [state(robot, tick) for tick in range(20) for robot in (2, 3, 4)]
    shuffled = states.copy()
    random.shuffle(shuffled)
    scenario = replace(SCENARIO, link=faults, seed=seed)

    def timeline(order: list[PeerState]) -> list[list[PeerState]]:
        link = Link(scenario, 1)
        for each in order:
            link.put(each)
        return [link.take(tick) for tick in range(60)]

    assert timeline(states) == timeline(shuffled)


def test_what_is_said_again_is_no_news() -> None:
    link = Link(SCENARIO, 1)
    told = [state(2, 3), state(3, 3), state(2, 3), state(2, 4), state(3, 3), state(2, 4), state(2, 5)]
    assert [link.is_news(each) for each in told] == [True, True, False, True, False, False, True]
    assert link.is_news(state(2, 5, 2))


def test_what_an_older_life_says_late_is_no_news_nor_makes_any() -> None:
    """Two processes of one robot live, and both say again what they said last, in any order."""
    link = Link(SCENARIO, 1)
    told = [(3, 1), (7, 2), (3, 1), (7, 2), (4, 1), (7, 2), (8, 2), (4, 1), (9, 3)]
    news = [each for each in told if link.is_news(state(2, *each))]
    assert news == [(3, 1), (7, 2), (8, 2), (9, 3)]
