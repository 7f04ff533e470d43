"""Whether what a process holds on to is flat over time.

Memory: a straight line is fitted to the second half; it may rise by no more than `RISE` or `SHARE` of
the mean over that half, whichever is more. Counts: no more in the last quarter than in the second.
The first quarter is left out: allocators and caches fill while a process warms up.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

RISE = 0.5  # MB
SHARE = 0.02
_FEWEST = 8  # samples from which anything can be said


class Memory(NamedTuple):
    """Private memory over the second half: mean, rise of the fitted line, and what it may rise."""

    mean: float  # MB
    rise: float  # MB, over the half
    per_hour: float  # MB
    allowed: float  # MB

    @property
    def flat(self) -> bool:
        """Whether it rises by no more than allowed."""
        return self.rise <= self.allowed


def memory(times: Sequence[float], megabytes: Sequence[float]) -> Memory | None:
    """The trend of memory; None where there are too few samples to tell."""
    half = len(times) // 2
    if len(times) < _FEWEST:
        return None
    t, m = np.asarray(times[half:]), np.asarray(megabytes[half:])
    slope = float(np.polyfit(t - t[0], m, 1)[0])
    mean = float(m.mean())
    return Memory(mean, slope * float(t[-1] - t[0]), slope * 3600.0, max(RISE, SHARE * mean))


def steady(counts: Sequence[float]) -> bool | None:
    """Whether a count is no higher in the last quarter than in the second; None with too few samples."""
    if len(counts) < _FEWEST:
        return None
    quarter = len(counts) // 4
    return max(counts[-quarter:]) <= max(counts[quarter : 2 * quarter])
