"""Age of odometry, by two clocks that were never set."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.bases.senses import DRIFT, LinkDelay

DELAYS = st.lists(st.floats(0.0, 0.2), min_size=1, max_size=50)


@given(st.floats(-1e9, 1e9), DELAYS)
def test_the_age_is_that_since_the_stamp_less_the_least_delay_whatever_the_clocks_show(offset, delays):
    link, stamps = LinkDelay(), [0.3 * n for n in range(len(delays))]  # so that none overtakes another
    for stamp, delay in zip(stamps, delays, strict=True):
        link.take(stamp + offset, stamp + delay)
    now = stamps[-1] + 0.5
    drift = DRIFT * 0.5 * (len(delays) + 1)
    assert now - stamps[-1] - link.age(stamps[-1] + offset, now) == pytest.approx(
        min(delays), abs=drift + 1e-6
    )


def test_a_delay_that_has_grown_counts_as_the_least_one_only_minutes_later():
    link = LinkDelay()
    link.take(0.0, 0.01)
    ages = []
    for second in range(1, 1200):
        link.take(float(second), second + 0.31)
        ages.append(link.age(float(second), second + 0.31))
    assert ages[60] > 0.25
    assert ages[-1] == pytest.approx(0.0, abs=1e-9)


def test_a_late_message_that_was_overtaken_makes_none_of_a_late_link_young():
    link = LinkDelay()
    for stamp, delay in ((0.0, 0.01), (9.98, 1.0), (10.02, 1.0), (10.0, 1.03), (10.04, 1.0)):
        link.take(stamp, stamp + delay)
        assert link.age(stamp, stamp + delay) > delay - 0.1


def test_a_clock_that_is_set_back_begins_a_new_difference_and_one_set_forward_makes_nothing_old():
    link = LinkDelay()
    for stamp, now in ((100.0, 0.0), (1000.0, 1.0), (20.0, 2.0)):
        link.take(stamp, now)
        assert link.age(stamp, now) == pytest.approx(0.0)
    assert math.isfinite(link.age(20.0, 3.0))
