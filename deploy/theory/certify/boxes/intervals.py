"""Interval arithmetic on pairs (low, high) of doubles, rounded outward.

Every bound is moved to a representable number beyond the exact one, by multiplication: that rests on
IEEE 754 round-to-nearest only, not on a rounding mode that a compiler may ignore. A bound may be
infinite; no operation below forms inf - inf or 0 * inf from bounds that its docstring allows.

All inner loops of the search are compiled by numba (extra `certify`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar, cast

from protocol.process.installation import missing_library

try:
    from numba import njit
except ModuleNotFoundError as error:
    raise missing_library("a certificate", "numba", "certify") from error

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The same function as machine code, kept on disk; strictly IEEE, nothing is reassociated or flushed."""
    return cast("F", njit(cache=True, error_model="numpy", fastmath=False)(function))


Interval = tuple[float, float]

_LESS = 1.0 - 2.0**-52
_MORE = 1.0 + 2.0**-52
_TINY = 1e-300  # covers underflow


@compiled
def down(x: float) -> float:
    """A double below every real number that rounds to x."""
    return (x * _LESS if x > 0.0 else x * _MORE) - _TINY


@compiled
def up(x: float) -> float:
    """A double above every real number that rounds to x."""
    return (x * _MORE if x > 0.0 else x * _LESS) + _TINY


@compiled
def add(a: Interval, b: Interval) -> Interval:
    """a + b; lower bounds below +inf, upper bounds above -inf."""
    return down(a[0] + b[0]), up(a[1] + b[1])


@compiled
def sub(a: Interval, b: Interval) -> Interval:
    """a - b, as `add`."""
    return down(a[0] - b[1]), up(a[1] - b[0])


@compiled
def mul(a: Interval, b: Interval) -> Interval:
    """a b, both finite."""
    s, t, u, v = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return down(min(s, t, u, v)), up(max(s, t, u, v))


@compiled
def weigh(weight: Interval, b: Interval) -> Interval:
    """weight b, with 0 <= weight, whose upper bound may be +inf, and finite b."""
    low = b[0] * (weight[1] if b[0] < 0.0 else weight[0])
    high = b[1] * (weight[1] if b[1] > 0.0 else weight[0])
    return down(low), up(high)


@compiled
def square(a: Interval) -> Interval:
    """a^2, finite; never below 0."""
    s, t = a[0] * a[0], a[1] * a[1]
    if a[0] <= 0.0 <= a[1]:
        return 0.0, up(max(s, t))
    return max(0.0, down(min(s, t))), up(max(s, t))


@compiled
def root_below(x: float) -> float:
    """A double not above the square root of x; 0 for x <= 0."""
    return max(0.0, down(math.sqrt(x))) if x > 0.0 else 0.0


@compiled
def root_above(x: float) -> float:
    """A double not below the square root of x; 0 for x <= 0."""
    return up(math.sqrt(x)) if x > 0.0 else 0.0


@compiled
def divide(a: Interval, b: Interval) -> Interval:
    """a / b; 0 is not in b, bounds of a may be infinite and those of b are finite."""
    s, t, u, v = a[0] / b[0], a[0] / b[1], a[1] / b[0], a[1] / b[1]
    return down(min(s, t, u, v)), up(max(s, t, u, v))


@compiled
def middle(a: Interval) -> float:
    """A double inside a finite interval, close to its middle."""
    return min(max(0.5 * (a[0] + a[1]), a[0]), a[1])
