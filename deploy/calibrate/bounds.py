"""From what was noted while a base drove a square, the bounds that a scenario has to state."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from statistics import fmean
from typing import Final, NamedTuple

from deploy.calibrate.square import PAUSE, Log, Move, Row

MARGIN: Final = 1.5  # how many times as much as was measured is to be stated
_BEGUN: Final = 0.1  # of the speed: above it, the base has begun
_FALLING: Final = 0.8  # of the speed: below it, the base brakes


class Bounds(NamedTuple):
    """What was measured."""

    noise_bound: float  # m, farthest of a pose at rest from the mean of that rest
    heading: float  # rad, likewise
    odometry: float  # share of a way that odometry is off, beyond what poses are
    error: float  # share of a way that the base is off what it was told, by odometry
    lag: float  # s, from a velocity that is sent to odometry that says it
    timeout: float  # s, from the last velocity to odometry that says that the base brakes
    acceleration: float  # m/s^2, at which it then brakes
    interval: float  # s, longest between two odometries


def bounds(log: Log) -> Bounds:
    """Everything that a square says of a base."""
    rests = [begin + move.duration for begin, move in log.moves if move.told and _stands(move)]  # their ends
    places = [(_mean(log.odometry, rest), _mean(log.poses, rest)) for rest in rests]
    noise = max(_farthest(log.poses, pose, rest) for (_, pose), rest in zip(places, rests, strict=True))
    heading = max(_widest(log.poses, pose, rest) for (_, pose), rest in zip(places, rests, strict=True))
    timeout, acceleration = _stop(log)
    return Bounds(
        noise,
        heading,
        _slip(places),
        _off(log),
        _lag(log),
        timeout,
        acceleration,
        max(b.time - a.time for a, b in pairwise(log.odometry)),
    )


def statements(found: Bounds) -> str:
    """Lines for a scenario: `MARGIN` times what was measured."""
    return "\n".join(
        (
            "[sensing]",
            "noise = 1e-3  # any that is not 0: the bound alone counts; add what every pose is off alike",
            f"noise_bound = {_up(MARGIN * found.noise_bound)}",
            f"heading = {_up(MARGIN * found.heading)}",
            "",
            "[base]",
            f"timeout = {_up(MARGIN * found.timeout)}",
            f"age = {_up(MARGIN * found.interval)}",
            "",
            "[body]  # besides kind, radius, offset, track and speed, which are measured with a ruler",
            f"acceleration = {_down(found.acceleration / MARGIN)}",
            f"error = {_up(MARGIN * found.error)}",
            f"lag = {_up(MARGIN * found.lag)}",
            f"odometry = {_up(MARGIN * found.odometry)}",
        )
    )


def _up(value: float) -> str:
    """Two digits, not less than the value."""
    return _digits(value, math.ceil)


def _down(value: float) -> str:
    return _digits(value, math.floor)


def _digits(value: float, rounded: Callable[[float], int]) -> str:
    if value <= 1e-6:
        return "0.0"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{rounded(value / unit - 1e-9) * unit:.6g}"


def _stands(move: Move) -> bool:
    return move.ahead == move.rate == 0.0


def _within(rows: Sequence[Row], end: float) -> list[Row]:
    """Rows of the second half of a rest, in which the base surely stands."""
    return [row for row in rows if end - 0.5 * PAUSE <= row.time <= end] or [
        min(rows, key=lambda row: abs(row.time - end))
    ]


def _mean(rows: Sequence[Row], end: float) -> Row:
    chosen = _within(rows, end)
    return Row(end, 0.0, *(fmean(getattr(row, name) for row in chosen) for name in ("x", "y", "yaw")))


def _farthest(rows: Sequence[Row], mean: Row, end: float) -> float:
    return max(math.hypot(row.x - mean.x, row.y - mean.y) for row in _within(rows, end))


def _widest(rows: Sequence[Row], mean: Row, end: float) -> float:
    return max(abs(row.yaw - mean.yaw) for row in _within(rows, end))


def _slip(places: Sequence[tuple[Row, Row]]) -> float:
    """The largest share by which a side's length differs between odometry and poses."""
    worst = 0.0
    for (one, before), (other, after) in pairwise(places):
        way = math.hypot(other.x - one.x, other.y - one.y)
        really = math.hypot(after.x - before.x, after.y - before.y)
        if way > 0.05:
            worst = max(worst, abs(really - way) / way)
    return worst


def _off(log: Log) -> float:
    """The largest share by which odometry says that a side was longer or shorter than told."""
    worst = 0.0
    for (begin, move), (end, _) in pairwise(log.moves):
        if move.told and move.ahead > 0.0 and log.moves[-1][0] != end:
            before, after = _mean(log.odometry, begin), _mean(log.odometry, end + PAUSE)
            way = math.hypot(after.x - before.x, after.y - before.y)
            worst = max(worst, abs(way - move.ahead * (end - begin)) / way)
    return worst


def _lag(log: Log) -> float:
    """The longest time from the first velocity of a side to odometry that says that the base has begun, s."""
    begun = []
    for begin, move in log.moves:
        if move.ahead > 0.0:
            later = (row.time for row in log.odometry if row.time > begin and row.ahead > _BEGUN * move.ahead)
            begun.append(next(later, math.inf) - begin)
    return max(begun)


def _stop(log: Log) -> tuple[float, float]:
    """How long the base goes on by itself, s, and how fast it then brakes, m/s^2."""
    silent, last = log.moves[-1][0], log.moves[-2][1]
    after = [row for row in log.odometry if row.time >= silent]
    low = [row for row in after if row.ahead < _FALLING * last.ahead]
    still = [row for row in after if row.ahead < (1.0 - _FALLING) * last.ahead]
    if not low or not still:
        return math.inf, 0.0
    fell = max(still[0].time - low[0].time, 1e-3)
    return low[0].time - silent, (2.0 * _FALLING - 1.0) * last.ahead / fell
