"""The reference flow: descent, accuracy, arrival; and the automatic k."""

import numpy as np
import pytest

from deploy.theory.exact_flow import integrate
from deploy.theory.function import obstacle_functions
from deploy.theory.tuning import automatic_k
from tests.deploy.theory.problems import crowded, free, log_ratio


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


def test_automatic_k_grows_with_robots_and_with_crowding_and_ignores_units() -> None:
    six = np.full(6, 0.04)
    assert automatic_k(six, 0.30) == 60.0
    assert automatic_k(six, 0.22) > 60.0
    assert automatic_k(np.full(24, 0.04), 1.2) == 960.0
    assert automatic_k(100 * six, 22.0) == pytest.approx(automatic_k(six, 0.22))
