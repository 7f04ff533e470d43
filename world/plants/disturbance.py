"""Random disturbances: uniform numbers by robot and tick, and bounded normal vectors made of them."""

from __future__ import annotations

import math

from protocol.draws import Purpose, generator
from protocol.messages import Vector

_BLOCK = 64  # ticks drawn at once; making a generator costs as much as some hundred numbers

_INSIDE = 1.0 - 1e-9  # keeps rounding in later sums from carrying a disturbance past its bound


def truncated_normal(radial: float, angular: float, deviation: float, bound: float) -> Vector:
    """An isotropic normal vector, conditioned on its length being at most `bound`.

    The length of an isotropic normal vector is Rayleigh distributed and independent of its angle,
    so two uniform numbers in [0, 1) give the truncated one by inversion.

    Args:
        radial, angular: uniform draws in [0, 1).
        deviation: standard deviation per axis before truncation, >= 0.
        bound: largest length, in the unit of `deviation`.
    """
    if deviation <= 0.0 or bound <= 0.0:
        return (0.0, 0.0)
    ratio = bound / deviation
    length = deviation * math.sqrt(-2.0 * math.log1p(radial * math.expm1(-0.5 * ratio * ratio)))
    length = min(length, bound * _INSIDE)
    angle = 2.0 * math.pi * angular
    return (length * math.cos(angle), length * math.sin(angle))


class Uniforms:
    """Uniform numbers in [0, 1) of one robot: the same for a tick, whatever was asked before."""

    def __init__(self, seed: int, purpose: Purpose, robot: int, columns: int) -> None:
        self._key = (seed, purpose, robot)
        self._columns = columns
        self._number = -1
        self._block: list[list[float]] = []

    def at(self, tick: int) -> list[float]:
        """The numbers of one tick, `columns` of them."""
        number, row = divmod(tick, _BLOCK)
        if number != self._number:
            seed, purpose, robot = self._key
            source = generator(seed, purpose, robot, number)
            self._number, self._block = number, source.random((_BLOCK, self._columns)).tolist()
        return self._block[row]


class UnitDisk:
    """Random vectors of one robot, evenly distributed in a disk whose radius is a little less than one."""

    def __init__(self, seed: int, purpose: Purpose, robot: int) -> None:
        self._draws = Uniforms(seed, purpose, robot, 2)

    def at(self, tick: int) -> Vector:
        """The vector of one tick."""
        size, direction = self._draws.at(tick)
        length, angle = math.sqrt(size) * _INSIDE, 2.0 * math.pi * direction
        return length * math.cos(angle), length * math.sin(angle)
