"""A normal disturbance in the plane, truncated in radius: bounded for certain, drawn without rejection."""

from __future__ import annotations

import math

from protocol.messages import Vector

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
