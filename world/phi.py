"""The judge's own navigation function, in logarithms (Karagoz, Bozma, Koditschek, equations (4), (5), (9)).

    phi = (gamma^k / (gamma^k + beta))^(1/k)

0 at the goal, 1 on the boundary of free space and, by convention here, everywhere outside it. Lengths in m.
"""

from __future__ import annotations

import math

import numpy as np

from protocol.scenario import Scenario
from world.clearance import Disks, Plane


class NavigationFunction:
    """phi of whole configurations of one scenario."""

    def __init__(self, scenario: Scenario, disks: Disks) -> None:
        goals = [complex(*scenario.spec(robot).goal) for robot in disks.ids]
        self._goals: Plane = np.array(goals)
        self._disks = disks
        self._gain = scenario.gain

    def __call__(self, positions: Plane) -> float:
        """phi at `positions` (shape (p,), complex, m); finite for any k and any number of robots."""
        offset = positions - self._goals
        relative = self._disks.relative(positions)
        contact, wall = self._disks.contact, self._disks.wall
        beta_pairs = relative.real**2 + relative.imag**2 - contact**2
        beta_wall = wall**2 - positions.real**2 - positions.imag**2
        beta = np.concatenate((beta_pairs, beta_wall))
        gamma = float((offset.real**2 + offset.imag**2).sum())
        if not float(beta.min()) > 0.0:
            return 1.0
        if gamma == 0.0:
            return 0.0
        return phi(math.log(gamma), float(np.log(beta).sum()), self._gain)


def phi(log_gamma: float, log_beta: float, gain: float) -> float:
    """phi from log gamma and log beta: exp(-softplus(log beta - k log gamma) / k)."""
    excess = log_beta - gain * log_gamma
    softplus = max(excess, 0.0) + math.log1p(math.exp(-abs(excess)))
    return math.exp(-softplus / gain)
