"""What the navigation function is tested on: 2, 3 and 6 robots, equal and unequal, and their clusters."""

import numpy as np
from scipy.sparse.csgraph import connected_components

from deploy.theory.exact_flow import random_configuration
from deploy.theory.function import FleetProblem, beta_pairs, gamma, obstacle_functions
from protocol.arrays import Reals
from protocol.draws import Purpose, generator

SIZES = (2, 3, 6)


def free(problem: FleetProblem, seed: int) -> Reals:
    """A random configuration in the interior of free space."""
    return random_configuration(generator(seed, Purpose.STUDY), problem.radii, problem.workspace)


def crowded(p: int, unequal: bool, k: float) -> FleetProblem:
    """Random goals for p robots of radius 4, or 3 to 5, in a workspace of radius 30."""
    radii = np.linspace(3.0, 5.0, p) if unequal else np.full(p, 4.0)
    goals = random_configuration(generator(0, Purpose.SCENARIO), radii, 30.0)
    return FleetProblem(goals, radii, 30.0, k)


def admissible(p: int, unequal: bool, k: float) -> FleetProblem:
    """Goals on a wide circle in a wide workspace: Assumptions 1 and 2 hold."""
    circle, workspace = {2: (20.0, 60.0), 3: (30.0, 90.0), 6: (170.0, 320.0)}[p]
    radii = np.linspace(3.6, 4.4, p) if unequal else np.full(p, 4.0)
    angle = 2.0 * np.pi * np.arange(p) / p + 0.1
    return FleetProblem(circle * np.stack([np.cos(angle), np.sin(angle)], axis=1), radii, workspace, k)


def log_ratio(problem: FleetProblem, b: Reals) -> float:
    """log phi_hat = k log gamma - log beta, equation (5), written independently of the code under test."""
    return float(problem.k * np.log(gamma(problem, b)) - np.log(obstacle_functions(problem, b)).sum())


def clusters(problem: FleetProblem, b: Reals, eps: float) -> list[list[int]]:
    """The partition P_1..P_s of robot indices (from 0), ordered by smallest member (Lemma B.3)."""
    beta = beta_pairs(problem, b)
    count, labels = connected_components((beta > 0.0) & (beta <= eps))  # N_eps(b, i), section 2.3
    return [np.flatnonzero(labels == label).tolist() for label in range(count)]


def circulation(b: Reals, members: list[int]) -> Reals:
    """v_z = sum over the cluster of J (b_n - g_z) (x) e_n, equation (15), (p, 2) m.

    All members circle their centroid g_z, the others stand still: the direction of negative curvature of
    Proposition C.4, hence a natural way off a saddle. J = [[0, 1], [-1, 0]].
    """
    arms = b[members] - b[members].mean(axis=0)
    v = np.zeros_like(b)
    v[members] = np.stack([arms[:, 1], -arms[:, 0]], axis=1)
    return v
