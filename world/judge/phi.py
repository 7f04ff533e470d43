"""The judge's own navigation function, in logarithms (Karagoz, Bozma, Koditschek, equations (4), (5), (9)).

    phi = (gamma^k / (gamma^k + beta))^(1/k)

Things enter beta like the disks of a sphere world (Koditschek and Rimon). 0 at the goal, 1 on the boundary of
free space and, by convention here, everywhere outside it. Lengths in m.
"""

from __future__ import annotations

import math

import numpy as np

from world.judge.clearance import Disks, Plane
from world.judge.goals import Goals

_TINY = np.finfo(np.float64).tiny  # stands for what is not positive, and is not looked at


class NavigationFunction:
    """phi of whole configurations; k is its exponent."""

    def __init__(self, disks: Disks, goals: Goals, k: float) -> None:
        self._disks, self._goals, self._k = disks, goals, k

    def __call__(self, positions: Plane) -> list[float]:
        """phi of each of n configurations (n, p), complex, m; finite for any k and number of robots."""
        offset = positions - self._goals.points
        relative = self._disks.relative(positions)
        beta_pairs = relative.real**2 + relative.imag**2 - self._disks.contact**2
        beta = np.concatenate((beta_pairs, self._disks.surroundings.beta(positions)), axis=-1)
        gamma = (offset.real**2 + offset.imag**2).sum(axis=-1).tolist()
        free = (beta.min(axis=-1) > 0.0).tolist()
        log_beta = np.log(np.maximum(beta, _TINY)).sum(axis=-1).tolist()
        return [
            self._value(each_gamma, each_log) if each_free else 1.0
            for each_free, each_gamma, each_log in zip(free, gamma, log_beta, strict=True)
        ]

    def _value(self, gamma: float, log_beta: float) -> float:
        return phi(math.log(gamma), log_beta, self._k) if gamma > 0.0 else 0.0


def phi(log_gamma: float, log_beta: float, k: float) -> float:
    """phi from log gamma and log beta: exp(-softplus(log beta - k log gamma) / k)."""
    excess = log_beta - k * log_gamma
    softplus = max(excess, 0.0) + math.log1p(math.exp(-abs(excess)))
    return math.exp(-softplus / k)
