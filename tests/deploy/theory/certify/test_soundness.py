"""No box that holds a critical point is ever emptied, and no box that holds a minimum is ever settled."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb

from deploy.theory.certify.boxes import derived, scene_of
from deploy.theory.certify.certificate import EMPTY, FALLS, GoalSet
from deploy.theory.certify.conditions import BoxConditions
from deploy.theory.certify.replay import Walk
from deploy.theory.certify.search import OPEN, Search, contract, contract_newton, settle
from tests.deploy.theory.certify.known import Known, blockade, boxes, forever, holds, known

pytestmark = pytest.mark.slow

SETS = 100


@pytest.mark.parametrize(
    "portion", [0, *(pytest.param(other, marks=pytest.mark.campaign) for other in (1, 2, 3))]
)
def test_contractors_keep_every_known_critical_point(portion: int) -> None:
    points = 0
    for seed in range(portion, SETS, 4):
        for found in known(seed):
            scene = scene_of(found.problem)
            out = derived(scene)
            points += 1
            for box in boxes(found, 10, seed):
                kept = contract(scene, box, out) and contract_newton(scene, box, out)
                assert kept, (seed, found.point)
                assert holds(box, found.row), (seed, found.point)
    assert points > 50


def test_no_known_minimum_is_ever_settled() -> None:
    minima = [blockade(k) for k in (1.8, 2.2, 2.4)]
    minima += [each for seed in range(SETS) for each in known(seed) if each.point.kind == "minimum"]
    assert len(minima) >= 10
    for number, found in enumerate(minima):
        scene = scene_of(found.problem)
        for box in boxes(found, 20, number):
            assert settle(scene, box, derived(scene)) == OPEN, found.point
            assert holds(box, found.row)


def test_most_small_boxes_around_saddles_are_settled() -> None:
    """Otherwise the test above would hold of a search that never settles anything."""
    settled = total = 0
    for seed in range(0, 30, 3):
        for found in known(seed):
            if found.point.kind == "saddle":
                scene = scene_of(found.problem)
                codes = [settle(scene, box, derived(scene)) for box in boxes(found, 10, seed)]
                total += len(codes)
                settled += sum(code in (EMPTY, FALLS) for code in codes)
    assert settled > 0.5 * total


def test_below_the_threshold_the_minimum_stays_in_an_open_box() -> None:
    found = blockade(2.2)
    scene = scene_of(found.problem)
    search = Search(scene, (1.0 / 2.25, 1.0 / 2.15))
    search.advance(30_000)
    assert any(holds(box, found.row) for box in search.open)


@pytest.mark.parametrize("equal", [True, False])
def test_goals_that_have_a_minimum_at_every_large_k_never_certify(equal: bool) -> None:
    found = forever(equal)
    scene = scene_of(found.problem)
    search = Search(scene, (0.0, 1e-4))
    search.advance(50_000)
    assert any(holds(box, found.row) for box in search.open)


def goals_of(found: Known) -> GoalSet:
    problem = found.problem
    goals = tuple((float(x), float(y)) for x, y in problem.goals)
    return GoalSet(goals, tuple(problem.radii.tolist()), problem.workspace)


def test_the_verifier_keeps_known_critical_points_and_settles_no_minimum() -> None:
    minima = [each for seed in range(SETS) for each in known(seed) if each.point.kind == "minimum"]
    chosen = [each for seed in range(0, SETS, 8) for each in known(seed)[:3]]
    chosen += [blockade(2.2), *minima[:20]]
    for number, found in enumerate(chosen):
        walk = Walk(goals_of(found), b"", lambda _: None)
        for box in boxes(found, 4, number):
            rows = [[arb(low), arb(high)] for low, high in box.tolist()]
            conditions = BoxConditions(goals_of(found), rows)
            settled = walk.settled(conditions) if found.point.kind == "minimum" else False
            assert not settled, found.point
            if found.point.kind != "minimum":
                assert walk.narrowed(conditions), found.point
            narrowed = np.array([[float(low.mid()), float(high.mid())] for low, high in conditions.rows])
            assert holds(narrowed, found.row), found.point
