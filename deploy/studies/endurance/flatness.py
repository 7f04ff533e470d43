"""Whether what a process holds on to is flat over time, over all lives of one that is started again.

Memory: straight lines of one slope, a level for each life, are fitted to the second half of every life. Over
the half of the longest life they may rise by no more than `RISE` or `SHARE` of the mean, whichever is more.
The slope's standard error takes into account how much alike neighbouring samples are. Counts: no more in the
last quarter of a life than in its second. What comes first is left out: allocators and caches fill while a
process warms up.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

RISE = 0.5  # MB
SHARE = 0.02
_FEWEST = 8  # samples from which anything can be said
_SAME = 0.99  # correlation of neighbours, at most: beyond, an error could not be told

Floats = NDArray[np.float64]


class Memory(NamedTuple):
    """Memory over second halves: mean, rise of the fitted line, and what it may rise."""

    mean: float  # MB
    rise: float  # MB, over the half of the longest life
    per_hour: float  # MB
    error: float  # MB an hour, standard error of `per_hour`
    allowed: float  # MB

    @property
    def flat(self) -> bool:
        """Whether it rises by no more than allowed."""
        return self.rise <= self.allowed


def memory(times: Sequence[float], megabytes: Sequence[float], pids: Sequence[float] = ()) -> Memory | None:
    """The trend of memory; None where no life has enough samples to tell.

    Args:
        times: s.
        megabytes: at these times.
        pids: whose samples these are; of one process unless given.
    """
    halves = [
        (np.asarray(times[(begin + end) // 2 : end]), np.asarray(megabytes[(begin + end) // 2 : end]))
        for begin, end in lives(len(times), pids)
        if end - begin >= _FEWEST
    ]
    if not halves:
        return None
    span = max(float(t[-1] - t[0]) for t, _ in halves)
    mean = float(np.concatenate([m for _, m in halves]).mean())
    slope, error = _slope([(t - t.mean(), m - m.mean()) for t, m in halves])
    return Memory(mean, slope * span, slope * 3600.0, error * 3600.0, max(RISE, SHARE * mean))


def lives(samples: int, pids: Sequence[float]) -> list[tuple[int, int]]:
    """Where the samples of each life begin and end."""
    changes = [n for n, (one, other) in enumerate(pairwise(pids), 1) if one != other]
    return list(pairwise([0, *changes, samples]))


def _slope(centred: Sequence[tuple[Floats, Floats]]) -> tuple[float, float]:
    """Of lines through centred times and values, and its standard error for residuals of the first order."""
    moments = sum(float(t @ t) for t, _ in centred)
    slope = sum(float(t @ m) for t, m in centred) / moments
    residuals = [m - slope * t for t, m in centred]
    squares = sum(float(r @ r) for r in residuals)
    freedom = sum(map(len, residuals)) - len(centred) - 1
    if squares == 0.0 or freedom < 1:
        return slope, 0.0
    alike = min(_SAME, max(0.0, sum(float(r[1:] @ r[:-1]) for r in residuals) / squares))
    return slope, (squares / freedom / moments * (1.0 + alike) / (1.0 - alike)) ** 0.5


def steady(counts: Sequence[float], pids: Sequence[float] = (), *, passing: bool = False) -> bool | None:
    """Whether a count is no higher in the last quarter of any life than in its second; None with too few
    samples. The most that was counted in a quarter, unless some are there, or missing, only in `passing`:
    then the least in the last, for what is never given back is in every sample, and the median in the second,
    for one that was missing for a moment does not count."""
    found = [counts[begin:end] for begin, end in lives(len(counts), pids) if end - begin >= _FEWEST]
    if not found:
        return None
    before, after = (np.median, np.min) if passing else (np.max, np.max)
    return all(after(c[-(len(c) // 4) :]) <= before(c[len(c) // 4 : 2 * (len(c) // 4)]) for c in found)
