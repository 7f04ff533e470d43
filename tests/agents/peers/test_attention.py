"""Whose States count follows from what the world said and from their ticks, whenever they arrive."""

from agents.peers.attention import Attention
from protocol.interest import LEAD


def test_everybody_counts_until_somebody_is_near() -> None:
    attention = Attention()
    assert attention.everybody
    assert attention.counts(7, 0)
    assert not attention.turn(0)


def test_no_life_hears_what_was_said_before_it() -> None:
    attention = Attention()
    attention.turn(7)
    assert [attention.counts(2, tick) for tick in (6, 7, 8)] == [False, True, True]
    attention.turn(8)
    assert attention.counts(2, 7)  # it was under way


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
    attention.turn(LEAD)
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
    assert attention.counts(2, LEAD)


def test_a_summary_is_taken_in_by_turns_but_all_are_near_at_once() -> None:
    first, second = Attention(0), Attention(1)
    for attention in (first, second):
        attention.announce(10, (2,), summed_up=True)
        assert attention.turn(10 + LEAD)
    assert (first.due, second.due) == (10, -1)
    assert not second.turn(11 + LEAD)
    assert second.due == 10
