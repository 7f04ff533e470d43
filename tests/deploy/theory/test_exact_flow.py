"""The reference flow: descent, accuracy, arrival; spurious minima below a threshold; unreachable goals."""

from dataclasses import replace

import numpy as np
import pytest

from deploy.theory.exact_flow import classify, find_equilibrium, integrate
from deploy.theory.function import FleetProblem, obstacle_functions, reduced_jacobian
from deploy.theory.tuning import automatic_k
from protocol.arrays import Reals
from tests.deploy.theory.problems import circulation, crowded, free, log_ratio


@pytest.mark.slow
@pytest.mark.parametrize("unequal", [False, True])
def test_flow_descends_without_contact_and_arrives(unequal: bool) -> None:
    problem = crowded(6, unequal, k=60.0)
    for seed in range(2):
        flow = integrate(problem, free(problem, seed))
        assert flow.arrived
        heights = [log_ratio(problem, b) for b in flow.path]
        assert (np.diff(heights) <= 1e-6).all()
        assert min(obstacle_functions(problem, b).min() for b in flow.path) > 0.0
        assert 1.0 <= flow.nrl < 2.0
        finer = integrate(problem, free(problem, seed), accuracy=1e-7)
        assert flow.nrl == pytest.approx(finer.nrl, rel=2e-3)


def stuck(problem: FleetProblem) -> Reals | None:
    """Where the flow ends other than at the goal, from eight random starts."""
    for seed in range(8):
        flow = integrate(problem, free(problem, seed))
        if not flow.arrived and (b := find_equilibrium(problem, flow.path[-1])) is not None:
            return b
    return None


@pytest.mark.slow
def test_small_k_has_other_minima_and_large_k_has_none_on_the_way() -> None:
    """The paper's remark on figure 5; at such a minimum circling climbs, so C.4 needs its "large enough"."""
    problem = crowded(6, False, k=3.0)
    b = stuck(problem)
    assert b is not None
    assert classify(problem, b).kind == "minimum"
    v = circulation(b, (0, 1)).ravel()
    assert v @ reduced_jacobian(problem, b) @ v > 0.0
    assert stuck(replace(problem, k=60.0)) is None


def test_automatic_k_grows_with_robots_and_with_crowding_and_ignores_units() -> None:
    six = np.full(6, 0.04)
    assert automatic_k(six, 0.30) == 60.0
    assert automatic_k(six, 0.22) > 60.0
    assert automatic_k(np.full(24, 0.04), 1.2) == 960.0
    assert automatic_k(100 * six, 22.0) == pytest.approx(automatic_k(six, 0.22))
