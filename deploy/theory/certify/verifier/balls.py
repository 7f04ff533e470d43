"""Intervals whose ends are Arb balls: each operation is enclosed by the library, nothing is rounded here.

An interval (l, h) stands for every x with x >= some number of l and x <= some number of h. Comparisons of
balls are true only where they hold for all their numbers; each choice below is right in either case.
"""

from __future__ import annotations

from collections.abc import Sequence

from protocol.process.installation import missing_library

try:
    from flint import arb
except ModuleNotFoundError as error:
    raise missing_library("verifying", "python-flint", "certify") from error

Ends = tuple[arb, arb]

ZERO, ONE, INFINITE = arb(0), arb(1), arb("+inf")


def exact(x: float) -> Ends:
    """A double."""
    return arb(x), arb(x)


def add(a: Ends, b: Ends) -> Ends:
    """a + b."""
    return a[0] + b[0], a[1] + b[1]


def sub(a: Ends, b: Ends) -> Ends:
    """a - b."""
    return a[0] - b[1], a[1] - b[0]


def negative(a: Ends) -> Ends:
    """-a."""
    return -a[1], -a[0]


def scale(w: Ends, b: Ends) -> Ends:
    """w b for w >= 0, whose upper end may be infinite, and finite b."""
    low = b[0] * w[0] if b[0] >= 0 else b[0] * w[1]
    high = b[1] * w[0] if b[1] <= 0 else b[1] * w[1]
    return low, high


def mul(a: Ends, b: Ends) -> Ends:
    """a b, both finite."""
    if a[0] >= 0:
        return scale(a, b)
    if b[0] >= 0:
        return scale(b, a)
    if a[1] <= 0:
        return negative(scale(negative(a), b))
    if b[1] <= 0:
        return negative(scale(negative(b), a))
    s, t, u, v = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return s.min(t).min(u.min(v)), s.max(t).max(u.max(v))


def square(a: Ends) -> Ends:
    """a^2."""
    s, t = a[0] * a[0], a[1] * a[1]
    if a[0] >= 0:
        return s, t
    if a[1] <= 0:
        return t, s
    return ZERO, s.max(t)


def over(a: Ends, b: Ends) -> Ends:
    """a / b for b > 0 or b < 0, finite; the ends of a may be infinite."""
    if b[0] > 0:
        low = a[0] / b[1] if a[0] >= 0 else a[0] / b[0]
        high = a[1] / b[1] if a[1] <= 0 else a[1] / b[0]
        return low, high
    return negative(over(a, negative(b)))


def ball(a: Ends) -> arb:
    """One ball that holds a finite interval."""
    return a[0].union(a[1])


def middle(row: Sequence[arb]) -> float:
    """Halfway between the ends, more or less."""
    return 0.5 * (float(row[0].mid()) + float(row[1].mid()))


def ends(x: arb) -> Ends:
    """A ball as an interval."""
    return x.lower(), x.upper()


def narrow(row: list[arb], new: Ends) -> bool:
    """Intersect [low, high] with `new` in place. False: certainly empty."""
    row[0] = max(row[0], new[0])
    row[1] = min(row[1], new[1])
    return not row[0] > row[1]


def rests(terms: list[Ends]) -> list[Ends]:
    """For each term the sum of all others."""
    before, after = [(ZERO, ZERO)], [(ZERO, ZERO)]
    for term in terms[:-1]:
        before.append(add(before[-1], term))
    for term in terms[:0:-1]:
        after.append(add(after[-1], term))
    return [add(one, other) for one, other in zip(before, reversed(after), strict=True)]
