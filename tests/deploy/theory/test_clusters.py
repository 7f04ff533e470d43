"""Clusters: Lemma B.3, and the recursive definition against plain reachability."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from deploy.theory.function import Array, Problem
from tests.deploy.theory.clusters import circulation, clusters, neighbours

points = st.lists(
    st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(0.5, 5.0)), min_size=1, max_size=9
)


def build(rows: list[tuple[float, float, float]]) -> tuple[Problem, Array]:
    table = np.array(rows)
    return Problem(table[:, :2], table[:, 2], 60.0, 60.0), table[:, :2]


@settings(max_examples=200, deadline=None)
@given(points, st.floats(1e-3, 500.0))
def test_clusters_are_a_partition(rows: list[tuple[float, float, float]], eps: float) -> None:
    """Lemma B.3: non-empty cells that cover all robots and do not overlap."""
    problem, b = build(rows)
    cells = clusters(problem, b, eps)
    assert all(cells)
    assert sorted(i for cell in cells for i in cell) == list(range(problem.p))
    assert [cell[0] for cell in cells] == sorted(cell[0] for cell in cells)


@settings(max_examples=200, deadline=None)
@given(points, st.floats(1e-3, 500.0))
def test_two_robots_share_a_cluster_exactly_when_neighbours_connect_them(
    rows: list[tuple[float, float, float]], eps: float
) -> None:
    problem, b = build(rows)
    near = neighbours(problem, b, eps)
    assert (near == near.T).all()
    steps = np.linalg.matrix_power(near.astype(int) + np.eye(problem.p, dtype=int), problem.p) > 0
    label = {i: number for number, cell in enumerate(clusters(problem, b, eps)) for i in cell}
    for i in range(problem.p):
        for j in range(problem.p):
            assert (label[i] == label[j]) == bool(steps[i, j])


def test_robots_in_contact_are_no_neighbours() -> None:
    """0 < beta_ij is strict in the definition."""
    problem, b = build([(0.0, 0.0, 1.0), (2.0, 0.0, 1.0), (4.1, 0.0, 1.0)])
    assert clusters(problem, b, 0.5) == ((0,), (1, 2))


def test_circulation_turns_every_member_about_the_centroid() -> None:
    _, b = build([(0.0, 0.0, 1.0), (4.0, 0.0, 1.0), (20.0, 9.0, 1.0)])
    v = circulation(b, (0, 1))
    np.testing.assert_allclose(v, [[0.0, 2.0], [0.0, -2.0], [0.0, 0.0]])
    assert ((b[:2] - b[:2].mean(axis=0)) * v[:2]).sum() == 0.0
