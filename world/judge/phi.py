"""The judge's own navigation function, in logarithms (Karagoz, Bozma, Koditschek, equations (4), (5), (9)).

    phi = (gamma^k / (gamma^k + beta))^(1/k)

Things enter beta like the disks of a sphere world (Koditschek and Rimon). 0 at the goal, 1 on the boundary of
free space and, by convention here, everywhere outside it. Lengths in m.
"""

from __future__ import annotations

import math

import numpy as np

from world.judge.clearance import Disks, Plane, Reals
from world.judge.goals import Goals
from world.judge.nearest import FEW

_TINY = np.finfo(np.float64).tiny  # stands for what is not positive, and is not looked at
_ROWS = 8  # of the triangle of many pairs, whose factors are multiplied before a logarithm is taken
_TWICE = np.tri(_ROWS, dtype=np.bool_)


class NavigationFunction:
    """phi of whole configurations; k is its exponent."""

    def __init__(self, disks: Disks, goals: Goals, k: float) -> None:
        self._disks, self._goals, self._k = disks, goals, k

    def __call__(self, positions: Plane) -> list[float]:
        """phi of each of n configurations (n, p), complex, m; finite for any k and number of robots."""
        offset = positions - self._goals.points
        gamma = (offset.real**2 + offset.imag**2).sum(axis=-1).tolist()
        return [
            self._value(each_gamma, each_log) if each_log > -math.inf else 1.0
            for each_gamma, each_log in zip(gamma, self._log_beta(positions), strict=True)
        ]

    def _log_beta(self, positions: Plane) -> list[float]:
        """Of each configuration; -inf outside free space."""
        disks = self._disks
        walls = disks.surroundings.beta(positions)
        if len(disks.contact) > FEW:
            return [
                _log_product(each, disks.surroundings.radii) + _log(wall)
                for each, wall in zip(positions, walls, strict=True)
            ]
        relative = disks.relative(positions)
        beta_pairs = relative.real**2 + relative.imag**2 - disks.contact**2
        beta = np.concatenate((beta_pairs, walls), axis=-1)
        found = np.log(np.maximum(beta, _TINY)).sum(axis=-1)
        logs: list[float] = np.where(beta.min(axis=-1) > 0.0, found, -math.inf).tolist()
        return logs

    def _value(self, gamma: float, log_beta: float) -> float:
        return phi(math.log(gamma), log_beta, self._k) if gamma > 0.0 else 0.0


def _log(beta: Reals) -> float:
    """Logarithm of the product; -inf unless all are positive."""
    return float(np.log(beta).sum()) if beta.min() > 0.0 else -math.inf


def _log_product(positions: Plane, radii: Reals) -> float:
    """`_log` of beta of all pairs, some rows of their triangle at a time."""
    x, y, total = positions.real.copy(), positions.imag.copy(), 0.0
    for begin in range(0, len(x), _ROWS):
        rows = slice(begin, begin + _ROWS)
        beta = (x[rows, None] - x[begin:]) ** 2
        beta += (y[rows, None] - y[begin:]) ** 2
        beta -= (radii[rows, None] + radii[begin:]) ** 2
        beta[:, : len(beta)][_TWICE[: len(beta), : len(beta)]] = 1.0  # each pair once
        if beta.min() <= 0.0:
            return -math.inf
        total += float(np.log(beta.prod(axis=0)).sum())
    return total


def phi(log_gamma: float, log_beta: float, k: float) -> float:
    """phi from log gamma and log beta: exp(-softplus(log beta - k log gamma) / k)."""
    excess = log_beta - k * log_gamma
    softplus = max(excess, 0.0) + math.log1p(math.exp(-abs(excess)))
    return math.exp(-softplus / k)
