"""No box that holds a critical point is ever emptied, and no box that holds a minimum is ever settled."""

import numpy as np
import pytest
from flint import arb

from deploy.theory.certify.boxes import Derived, Scene, derived, scene_of
from deploy.theory.certify.certificate import GoalSet
from deploy.theory.certify.conditions import BoxConditions
from deploy.theory.certify.contractors import enclose
from deploy.theory.certify.curvature import corrected, form
from deploy.theory.certify.replay import Walk
from deploy.theory.certify.search import OPEN, Search, contract, contract_newton, settle
from protocol.arrays import Reals
from protocol.draws import Purpose, generator
from tests.deploy.theory.certify.known import Known, blockade, boxes, forever, half_form, holds, known

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


BELOW, LARGE = (1.0 / 2.25, 1.0 / 2.15), (0.0, 1e-4)  # kappa below the threshold; of every large k
MINIMA = [(blockade, 2.2, BELOW), (forever, True, LARGE), (forever, False, LARGE)]


@pytest.mark.parametrize(("minimum", "which", "kappa"), MINIMA)
def test_where_there_is_a_minimum_it_stays_in_an_open_box(minimum, which, kappa) -> None:
    found = minimum(which)
    search = Search(scene_of(found.problem), kappa)
    search.advance(20_000)
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
        walk = Walk(goals_of(found), b"")
        for box in boxes(found, 4, number):
            rows = [[arb(low), arb(high)] for low, high in box.tolist()]
            conditions = BoxConditions(goals_of(found), rows)
            settled = walk.settled(conditions) if found.point.kind == "minimum" else False
            assert not settled, found.point
            if found.point.kind != "minimum":
                assert walk.narrowed(conditions), found.point
            narrowed = np.array([[float(low.mid()), float(high.mid())] for low, high in conditions.rows])
            assert holds(narrowed, found.row), found.point


# -- bounds of the second-order tests against the Hessian itself


def points() -> list[Known]:
    """Minima, and saddles of two to four robots, at the wall too."""
    return [
        blockade(2.2),
        *(found for seed in range(20) for found in known(seed) if found.point.kind != "maximum"),
    ]


def around(found: Known, width: float) -> tuple[Scene, Reals, Derived]:
    scene, row = scene_of(found.problem), found.row
    n = 2 * found.problem.p
    margin = width * np.where(np.arange(len(row)) < n, 0.1, np.abs(row))
    box = np.stack([row - margin, row + margin], axis=1)
    out = derived(scene)
    assert enclose(scene, box, out)
    return scene, box, out


def test_the_corrected_field_is_orthogonal_to_the_chosen_gradients() -> None:
    """It holds, for every b of a box, v - W z."""
    for number, found in enumerate(points()):
        draw = generator(number, Purpose.STUDY)
        scene, box, out = around(found, 3e-2)
        n = len(scene.goals)
        stiff = draw.integers(len(scene.first), size=1)
        v, field = draw.standard_normal(n), np.empty((n, 2))
        assert corrected(scene, box, out, stiff, v, field)
        w = gradient(scene, box[:n].mean(axis=1), stiff[0])
        for _ in range(10):
            row = gradient(scene, draw.uniform(box[:n, 0], box[:n, 1]), stiff[0])
            exact = v - w * (row @ v) / (row @ w)
            assert ((field[:, 0] - 1e-12 <= exact) & (exact <= field[:, 1] + 1e-12)).all()


def test_the_quadratic_form_is_bounded_from_above_and_closely() -> None:
    for number, found in enumerate(points()):
        scene, box, out = around(found, 1e-9)
        v = generator(number, Purpose.STUDY).standard_normal(len(scene.goals))
        none = np.empty(0, dtype=np.int64)
        bound = form(scene, box, out, none, np.stack([v, v], axis=1))
        exact = half_form(found, v)
        assert exact - 1e-9 * abs(exact) <= bound <= exact + 1e-3 * abs(exact) + 1e-3


def gradient(scene: Scene, b: Reals, q: int) -> Reals:
    row, i, j = np.zeros_like(b), scene.first[q], scene.second[q]
    apart = b[2 * i : 2 * i + 2] - (b[2 * j : 2 * j + 2] if j >= 0 else 0.0)
    row[2 * i : 2 * i + 2] = -apart if j < 0 else apart
    if j >= 0:
        row[2 * j : 2 * j + 2] = -apart
    return row
