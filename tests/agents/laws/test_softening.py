"""A softer repulsion once States are late: near the goal only, by little, and continuous."""

from __future__ import annotations

from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.laws.softening import AT_ALL, LATEST, SOFTER, WHOLLY, softened
from deploy.library.goal_sets import figure_3
from deploy.run.local import LocalFleet
from deploy.studies.peers.places import Place, contest

K = 60.0
distances = st.floats(0.0, 20.0)  # radii
latencies = st.floats(0.0, 10.0)  # laps


@given(distances)
def test_fresh_states_change_nothing(away: float) -> None:
    assert softened(K, away, 0.0) == K


@given(st.floats(AT_ALL, 100.0), latencies)
def test_nothing_is_softer_far_from_the_goal(away: float, latency: float) -> None:
    assert softened(K, away, latency) == K


@given(st.floats(0.0, WHOLLY), st.floats(LATEST, 100.0))
def test_at_the_goal_it_is_softest_and_no_later_state_makes_it_softer(away: float, latency: float) -> None:
    assert softened(K, away, latency) == pytest.approx(K / (1.0 + SOFTER))


@given(distances, distances, latencies, latencies)
def test_nearer_and_later_is_softer_without_a_leap(a: float, b: float, c: float, d: float) -> None:
    near, far, early, late = min(a, b), max(a, b), min(c, d), max(c, d)
    assert softened(K, near, late) <= softened(K, far, early) <= K
    steepest = K * SOFTER * ((far - near) / (AT_ALL - WHOLLY) + late - early)
    assert softened(K, far, early) - softened(K, near, late) <= steepest + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("law", ["gradient", "reciprocal"])
def test_late_robots_get_to_tight_goals_sooner(law: str) -> None:
    place = Place("tight 3.30", partial(figure_3, "d"), 0.3)
    control = {"law": law, "filter": "separating-lines"}
    took = 0.0
    for seed in range(8):
        report = LocalFleet([contest(place, control, seed)]).execute()[0]
        assert report["verdict"] == "arrived"
        took += report["sim_time"]
    assert took < 51.5  # s; with the same k as for fresh States 53.4 and 55.3
