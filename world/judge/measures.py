"""Measures of a fleet on its way to its goals (Karagöz, Bozma, Koditschek, equations 4, 5, 9, and section 4).

    phi = (gamma^k / (gamma^k + beta))^(1/k)

Obstacles enter beta like the disks of a sphere world (Koditschek and Rimon). phi is 0 at the goal, 1 on the
boundary of free space and, by convention here, everywhere outside it. Lengths in m.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import msgspec
import numpy as np

from protocol.arrays import Complexes, Reals
from protocol.messages import Id, Vector
from protocol.scenario.model import Scenario
from world.judge.clearance import FEW, Disks

_CENTIMETRES = 100.0
_MOST = 300.0  # decades, in place of an infinite logarithm
_TINY = np.finfo(np.float64).tiny  # in place of unused values that are not positive
_ROWS = 8  # factors, of pairs or gaps, that are multiplied before a logarithm
_TWICE = np.tri(_ROWS, dtype=np.bool_)


class Goals(msgspec.Struct, frozen=True, dict=True):
    """Straight paths of robots to their goals. Immutable."""

    # Start of the straight path to the present goal, and the goal, m, by id, ascending.
    ways: dict[Id, tuple[Vector, Vector]]
    behind: float = 0.0  # length of straight paths to earlier goals, m

    @classmethod
    def of(cls, scenario: Scenario) -> Goals:
        """The straight paths of a scenario."""
        specs = map(scenario.spec, scenario.ids)
        return cls({spec.id: (spec.start, spec.goal) for spec in specs})

    @cached_property
    def begins(self) -> Complexes:
        """Starts of the straight paths, as complex numbers x + iy, shape (p,)."""
        return np.array([complex(*begin) for begin, _ in self.ways.values()])

    @cached_property
    def points(self) -> Complexes:
        """The present goals, shape (p,)."""
        return np.array([complex(*goal) for _, goal in self.ways.values()])

    def to(self, robot: int, goal: Vector, position: Vector) -> Goals:
        """The same with another goal of a robot: its present straight path ends at `position`."""
        begin, _ = self.ways[robot]
        return Goals({**self.ways, robot: (position, goal)}, self.behind + math.dist(position, begin))

    def of_fleet(self, scenario: Scenario) -> Goals:
        """The same for a changed fleet: new paths begin at starts, those of removed robots end at goals."""
        new = Goals.of(scenario).ways
        gone = [math.dist(*way) for robot, way in self.ways.items() if robot not in new]
        return Goals({robot: self.ways.get(robot, way) for robot, way in new.items()}, sum(gone, self.behind))

    @property
    def straight(self) -> float:
        """Total length of all straight paths so far, including the present ones."""
        return self.behind + float(np.abs(self.points - self.begins).sum())

    def deviations(self, positions: Complexes) -> Reals:
        """Distance of each centre from the segment of its straight path, shapes (n, p).

        A convex function of the position: during straight motion it is largest at an end.
        """
        ways = self.points - self.begins
        lengths = np.abs(ways)
        # Factors that rotate every path onto the real axis.
        turns = np.divide(np.conj(ways), lengths, out=np.ones_like(ways), where=lengths > 0.0)
        turned = (positions - self.begins - 0.5 * ways) * turns
        along = np.maximum(np.abs(turned.real) - 0.5 * lengths, 0.0)
        return np.hypot(along, turned.imag)


def tight(disks: Disks, goals: Goals) -> float | None:
    """Tightness of the goals: 100 / log10 of the product over pairs of |g_ij|^2 - rho_ij^2, in cm.

    None where the measure is undefined: fewer than two robots, goals that touch or overlap, or goals so close
    that the logarithm is not positive.
    """
    apart = disks.relative(goals.points)
    factors = _CENTIMETRES**2 * (apart.real**2 + apart.imag**2 - disks.contact**2)
    if (factors <= 0.0).any():
        return None
    total = math.fsum(math.log10(factor) for factor in factors)
    return 100.0 / total if total > 0.0 else None


def normalised_length(goals: Goals, lengths: dict[int, float]) -> float | None:
    """nrl: path lengths (by robot id) over straight distances to the goals, summed over robots.

    None when every robot starts at its goal.
    """
    straight = goals.straight
    return math.fsum(lengths.values()) / straight if straight > 0.0 else None


class Level(NamedTuple):
    """Distance of a configuration from the goal, by phi."""

    phi: float  # the navigation function; 1.0 to all digits in a large fleet, until the end
    # log10(gamma^k / beta) / k, which increases with phi; -300 at the goal, and 300 in contact, where it is
    # infinite.
    log_potential: float


def levels_of(disks: Disks, goals: Goals, k: float, positions: Complexes) -> list[Level]:
    """Levels of n configurations, shape (n, p); finite for any k and number of robots."""
    offset = positions - goals.points
    gamma = (offset.real**2 + offset.imag**2).sum(axis=-1).tolist()
    found = []
    for each, log_beta in zip(gamma, _log_beta(disks, positions), strict=True):
        if log_beta == -math.inf:
            found.append(Level(1.0, _MOST))
        elif each > 0.0:
            log_potential = (math.log(each) - log_beta / k) / math.log(10.0)
            found.append(Level(phi(math.log(each), log_beta, k), max(-_MOST, min(log_potential, _MOST))))
        else:
            found.append(Level(0.0, -_MOST))
    return found


def phi(log_gamma: float, log_beta: float, k: float) -> float:
    """phi from log gamma and log beta: exp(-softplus(log beta - k log gamma) / k)."""
    excess = log_beta - k * log_gamma
    softplus = max(excess, 0.0) + math.log1p(math.exp(-abs(excess)))
    return math.exp(-softplus / k)


def _log_beta(disks: Disks, positions: Complexes) -> list[float]:
    """log beta of each configuration; -inf outside free space."""
    walls = disks.beta(positions)
    if len(disks) > FEW:
        return [
            _log_product(each, disks.radii) + _log(wall) for each, wall in zip(positions, walls, strict=True)
        ]
    relative = disks.relative(positions)
    beta_pairs = relative.real**2 + relative.imag**2 - disks.contact**2
    beta = np.concatenate((beta_pairs, walls), axis=-1)
    found = np.log(np.maximum(beta, _TINY)).sum(axis=-1)
    logs: list[float] = np.where(beta.min(axis=-1) > 0.0, found, -math.inf).tolist()
    return logs


def _log(beta: Reals) -> float:
    """Logarithm of the product; -inf unless all are positive."""
    if beta.min() <= 0.0:
        return -math.inf
    return float(np.log(np.multiply.reduceat(beta, np.arange(0, len(beta), _ROWS))).sum())


def _log_product(positions: Complexes, radii: Reals) -> float:
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
