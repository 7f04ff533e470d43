"""Late States: peers that go first are foreseen, and gain and speed near the goal follow the latency."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.law.late_states import FIRST, KEPT, LATEST, SOFT_AT_ALL, SOFT_IN_FULL, SOFTER, foreseen, late_gain
from agents.peers.state import Peer, PeerState

R = 0.04
PERIOD = 0.05  # s
LAP = 0.4  # s
ME = Peer(0.0, 0.0, R, 0.01)


def peer(x: float, y: float, gamma: float, vx: float = 0.0, vy: float = 0.0, tick: int = 0) -> PeerState:
    return PeerState(2, 1, tick, True, x, y, 0.0, gamma, 1.0, vx, vy, radius=R)


def place(of: PeerState, tick: int) -> tuple[float, float]:
    (found,) = foreseen(ME, [of], tick, PERIOD, LAP)
    assert (found.radius, found.gamma) == (of.radius, of.gamma)
    return found.x, found.y


def test_a_peer_that_goes_first_has_gone_on_as_it_wished() -> None:
    assert place(peer(0.3, 0.1, 0.09, -0.1, 0.05), 4) == pytest.approx((0.28, 0.11))


def test_a_robot_that_has_less_far_to_go_or_is_heard_at_once_is_where_it_was_heard() -> None:
    assert place(peer(0.3, 0.1, FIRST * ME.gamma, -0.1), 4) == (0.3, 0.1)
    assert place(peer(0.3, 0.1, 0.09, -0.1, tick=4), 4) == (0.3, 0.1)


@given(
    st.floats(0.0, 0.2),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 0.5),
    st.floats(-math.pi, math.pi),
    st.integers(0, 20),
)
def test_some_of_the_gap_remains_even_of_one_that_would_have_passed(
    gap: float, bearing: float, speed: float, heading: float, age: int
) -> None:
    distance = 2.0 * R + gap
    x, y = distance * math.cos(bearing), distance * math.sin(bearing)
    vx, vy = speed * math.cos(heading), speed * math.sin(heading)
    seen = place(peer(x, y, 0.09, vx, vy), age)
    for part in (0.25, 0.5, 0.75, 1.0):
        passed = math.hypot(x + part * (seen[0] - x), y + part * (seen[1] - y))
        assert passed >= 2.0 * R + KEPT * gap - 1e-9
    assert math.hypot(seen[0] - x, seen[1] - y) <= speed * age * PERIOD + 1e-12


K = 60.0
distances = st.floats(0.0, 20.0)  # radii
latencies = st.floats(0.0, 10.0)  # laps


@given(distances, distances, latencies, latencies)
def test_nearer_and_later_is_softer_without_a_leap(a: float, b: float, c: float, d: float) -> None:
    near, far, early, late = min(a, b), max(a, b), min(c, d), max(c, d)
    assert late_gain(K, near, late) <= late_gain(K, far, early) <= K
    assert late_gain(K, near, 0.0) == late_gain(K, near + SOFT_AT_ALL, late) == K
    assert late_gain(K, 0.0, late + LATEST) == pytest.approx(K / (1.0 + SOFTER))
    steepest = K * SOFTER * ((far - near) / (SOFT_AT_ALL - SOFT_IN_FULL) + late - early)
    assert late_gain(K, far, early) - late_gain(K, near, late) <= steepest + 1e-9
