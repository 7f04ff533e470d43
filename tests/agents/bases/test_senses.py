"""Age of odometry, by two clocks that were never set."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.bases.ros_messages import NANO, Odometry, Pose, Velocity, header_at
from agents.bases.senses import DRIFT, LinkDelay, Odometer
from protocol.scenario.body import PRESETS, Base

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


def odometry(stamp: float, x: float) -> Odometry:
    """What a base says at a time, s, that is on the x axis at x, m."""
    pose = Pose([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])
    header = header_at(round(stamp * NANO), "odom")
    return Odometry(header, "base_link", pose, [0.0] * 36, Velocity([0.0] * 3, [0.0] * 3), [0.0] * 36)


@pytest.mark.parametrize(
    ("clock", "silent", "says"),
    [
        (0.0, 0.02, r"odometry jumps by 0\.3"),
        (0.0, 1.0, "odometry pauses for 1 s"),  # in which a base may have come as far
        (-1e9, 1.0, "odometry goes back in time"),
        (0.2, 0.02, r"the clock of odometry jumps ahead by 0\.2"),
        (1e9, 1.0, "odometry pauses for 1e"),
    ],
)
def test_a_publisher_that_begins_again_is_no_motion(clock, silent, says):
    """Its origin is where the base stands by then, its clock any."""
    odometer = Odometer(Base(), PRESETS["turtlebot3-burger"])
    for step in range(50):
        assert odometer.take(odometry(1e9 + 0.02 * step, 0.3), 0.02 * step) == ""
    now = 0.98 + silent
    assert re.match(says, odometer.take(odometry(1e9 + clock + now, 0.0), now))
    odometer.forget()
    for step in range(50):
        later = now + 0.02 * step
        assert odometer.take(odometry(1e9 + clock + later, 0.0), later) == ""


def test_odometry_of_which_some_is_lost_or_late_goes_on():
    odometer = Odometer(Base(), PRESETS["turtlebot3-burger"])
    for stamp, delay in ((0.0, 0.03), (0.02, 0.0), (0.2, 0.3), (0.22, 0.28), (0.4, 0.1)):
        assert odometer.take(odometry(stamp, 0.1 * stamp), stamp + delay) == ""
