"""Triples of disks that can never line up, against brute force."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.theory.check import mirrored_triples
from deploy.theory.function import FleetProblem


@settings(max_examples=100, deadline=None)
@given(st.lists(st.floats(0.5, 5.0), min_size=3, max_size=7), st.floats(3.0, 14.0))
def test_a_mirror_image_is_unreachable_for_exactly_the_wide_triples(
    radii: list[float], workspace: float
) -> None:
    angle = 2.4 * np.arange(len(radii))
    start = np.stack([np.cos(angle), np.sin(angle)], axis=1) * workspace
    problem = FleetProblem(start * (1.0, -1.0), np.array(radii), workspace, 60.0)
    triples = combinations(range(len(radii)), 3)
    wide = [triple for triple in triples if problem.radii[list(triple)].sum() > workspace]
    assert mirrored_triples(problem, start) == wide
    assert mirrored_triples(FleetProblem(start, problem.radii, workspace, 60.0), start) == []
