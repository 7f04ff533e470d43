"""Whose States count follows from what the world said and from their ticks, whenever they arrive."""

from collections.abc import Mapping

import pytest

from agents.peers.attention import Attention
from agents.peers.far import Places, places_of
from protocol.crowd.interest import LEAD
from protocol.messages import Summary
from world.coordinator.crowd.interest import runs


def test_everybody_counts_until_somebody_is_near() -> None:
    attention = Attention()
    assert attention.everybody
    assert attention.counts(7, 0)
    assert not attention.turn(0)


def test_nobody_hears_what_was_said_while_they_took_no_part() -> None:
    attention = Attention()
    attention.turn(7)
    assert [attention.counts(2, tick) for tick in (6, 7, 8)] == [False, True, True]
    attention.turn(8)
    assert attention.counts(2, 7)  # it was under way
    attention.turn(11)
    attention.turn(13)
    assert [tick for tick in range(14) if attention.counts(2, tick)] == [7, 8, 11, 13]


def test_of_many_pauses_none_is_forgotten() -> None:
    attention = Attention()
    for tick in range(0, 400, 2):
        attention.turn(tick)
    assert [tick for tick in range(399) if attention.counts(2, tick)] == list(range(0, 399, 2))


def test_where_nobody_waits_a_missed_tick_is_no_pause() -> None:
    attention = Attention(lockstep=False)
    for tick in range(1, 40, 2):  # the Ticks between are lost
        attention.turn(tick)
    assert all(attention.counts(2, tick) for tick in range(40))


def test_who_comes_near_counts_from_a_stated_tick_on() -> None:
    attention = Attention()
    attention.announce(10, (4, 2), summed_up=True)
    assert not any(attention.turn(10 + tick) for tick in range(LEAD))
    assert (attention.near, attention.due) == ((), -1)
    assert attention.turn(10 + LEAD)
    assert (attention.near, attention.due) == ((2, 4), 10)
    assert not attention.turn(11 + LEAD)
    assert not attention.counts(2, 9 + LEAD)  # it may have been heard, or not
    assert attention.counts(2, 10 + LEAD)
    assert not attention.counts(3, 10 + LEAD)


def test_who_stays_near_counts_without_a_gap_and_who_leaves_does_not() -> None:
    attention = Attention()
    attention.announce(0, (2, 3), summed_up=True)
    for tick in range(10 + LEAD):
        attention.turn(tick)
    attention.announce(10, (3, 5), summed_up=True)
    assert attention.counts(2, 9 + LEAD)
    attention.turn(10 + LEAD)
    assert not attention.counts(2, 9 + LEAD)
    assert attention.counts(3, 9 + LEAD)
    assert not attention.counts(5, 9 + LEAD)


def test_who_missed_the_tick_hears_from_the_next_on() -> None:
    attention = Attention()
    attention.announce(0, (2,), summed_up=False)
    assert not attention.turn(0)
    assert attention.turn(LEAD + 5)
    assert attention.due == -1
    assert attention.counts(2, LEAD + 5)
    assert not attention.counts(2, LEAD)


def summed_up(tick: int, *ids: int) -> Places:
    numbers = bytes(4 * len(ids))
    return places_of(Summary(tick, runs(ids), 2 * numbers, numbers, numbers))


def taken(attention: Attention, radii: Mapping[int, float] | None = None) -> int:
    """Tick of the summary that is taken in now; -1 for none."""
    assert attention.has_summary
    picture = attention.new_picture(radii or {})
    return -1 if picture is None else picture.tick


def test_the_summary_that_is_due_is_taken_in_however_many_have_arrived() -> None:
    attention = Attention(turn=1)
    attention.announce(10, (2,), summed_up=True)
    attention.turn(10)
    for tick in (10, 20, 20, 30):  # it is paused before the first is due
        attention.on_summary(summed_up(tick, 2))
    attention.turn(34)
    assert taken(attention) == 10
    assert taken(attention) == -1
    attention.announce(40, (2,), summed_up=True)
    attention.turn(41 + LEAD)
    assert not attention.has_summary
    attention.on_summary(summed_up(40, 2))
    assert taken(attention) == 40
    attention.on_summary(summed_up(40, 2))  # told again
    assert taken(attention) == -1


def test_a_later_summary_will_do_if_the_one_that_is_due_was_lost() -> None:
    attention = Attention()
    attention.announce(10, (2,), summed_up=True)
    attention.turn(10 + LEAD)
    attention.on_summary(summed_up(20, 2))
    assert taken(attention) == 20


def test_of_a_backlog_the_oldest_and_the_newest_stay() -> None:
    attention = Attention()
    attention.announce(10, (2,), summed_up=True)
    for tick in range(10, 1010, 10):
        attention.on_summary(summed_up(tick, 2))
    attention.turn(10 + LEAD)
    assert taken(attention) == 10
    attention.announce(1000, (2,), summed_up=True)
    attention.turn(1000 + LEAD)
    assert taken(attention) == 1000


@pytest.mark.parametrize("early", [False, True])
def test_who_could_not_take_in_any_takes_in_the_one_that_is_due_whether_the_next_has_come_or_not(
    early: bool,
) -> None:
    attention = Attention()
    for tick in range(0, 200, 10):
        attention.announce(tick, (2,), summed_up=True)
        attention.on_summary(summed_up(tick, 2))
        attention.turn(tick)
        attention.turn(tick + LEAD)
        assert attention.has_summary  # and where the robot is it does not know yet
    if early:
        attention.on_summary(summed_up(200, 2))
    attention.announce(200, (2,), summed_up=True)
    attention.turn(200)
    assert taken(attention) == 190


def test_a_robot_has_the_size_that_is_known_when_the_summary_is_taken_in() -> None:
    attention = Attention()
    attention.on_summary(summed_up(0, 2))
    attention.announce(0, (), summed_up=True)
    attention.turn(LEAD)
    picture = attention.new_picture({2: 0.25})
    assert picture is not None
    assert picture.field((2.0, 0.0), 0.5, ()).log_x == pytest.approx(2.0 / (4.0 - 0.75**2))


def test_a_summary_is_taken_in_by_turns_but_all_are_near_at_once() -> None:
    first, second = Attention(0), Attention(1)
    for attention in (first, second):
        attention.announce(10, (2,), summed_up=True)
        assert attention.turn(10 + LEAD)
    assert (first.due, second.due) == (10, -1)
    assert not second.turn(11 + LEAD)
    assert second.due == 10
