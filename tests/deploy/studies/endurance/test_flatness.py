"""When memory, handles and threads count as flat."""

from __future__ import annotations

import os

import numpy as np
import pytest

from deploy.studies.endurance.flatness import memory, steady
from deploy.studies.endurance.samples import QUANTITIES, Samples

HALF_HOUR = [10.0 * n for n in range(180)]


def test_a_line_is_fitted_to_the_second_half() -> None:
    filling = [min(10.0, 5.0 + t / 100.0) for t in HALF_HOUR]  # warm after 500 s
    trend = memory(HALF_HOUR, filling)
    assert trend is not None
    assert trend.flat
    assert trend.mean == pytest.approx(10.0)
    leaking = memory(HALF_HOUR, [10.0 + t / 1000.0 for t in HALF_HOUR])
    assert leaking is not None
    assert leaking.rise == pytest.approx(0.89, abs=0.01)
    assert leaking.per_hour == pytest.approx(3.6)
    assert not leaking.flat


def test_a_large_process_may_rise_by_a_share() -> None:
    trend = memory(HALF_HOUR, [100.0 + t / 1000.0 for t in HALF_HOUR])
    assert trend is not None
    assert trend.allowed == pytest.approx(0.02 * trend.mean)
    assert trend.flat


def test_the_slope_of_many_lives_is_that_within_them_with_its_error() -> None:
    rng = np.random.default_rng(0)
    times = [10.0 * n for n in range(600)]
    pids = [float(n // 100) for n in range(600)]
    # each life begins lower, at another level, and leaks 3.6 MB an hour
    leaking = [5.0 + pid + (t % 1000.0) / 1000.0 for t, pid in zip(times, pids, strict=True)]
    noisy = [m + e for m, e in zip(leaking, rng.normal(0.0, 0.05, 600), strict=True)]
    trend = memory(times, noisy, pids)
    assert trend is not None
    assert trend.per_hour == pytest.approx(3.6, abs=3.0 * trend.error)
    assert 0.0 < trend.error < 0.2
    assert trend.rise == pytest.approx(0.49, abs=0.03)  # over the half of one life
    short = memory(times[:20], leaking[:20], [float(n // 4) for n in range(20)])
    assert short is None


def test_neighbours_that_are_alike_say_less() -> None:
    rng = np.random.default_rng(1)
    steps = [5.0 + 0.1 * (-1.0) ** (n // 10) for n in range(180)]
    single = [5.0 + e for e in rng.choice((-0.1, 0.1), 180)]
    alike, apart = memory(HALF_HOUR, steps), memory(HALF_HOUR, single)
    assert alike is not None
    assert apart is not None
    assert alike.error > 2.0 * apart.error
    assert memory(HALF_HOUR, [5.0] * 180) == (5.0, 0.0, 0.0, 0.0, 0.5)


def test_counts() -> None:
    assert steady([9, 9, 10, 11, 11, 11, 11, 11])
    assert steady([9, 9, 11, 10, 9, 9, 10, 10])
    assert steady([9, 9, 10, 10, 10, 10, 10, 11]) is False
    lives = [9, 9, 9, 9, 9, 9, 9, 9, 4, 4, 4, 4, 4, 5, 5, 5]
    assert steady(lives[:8] * 2, [1] * 8 + [2] * 8)
    assert steady(lives, [1] * 8 + [2] * 8) is False
    passing = [9] * 4 * 5 + [9, 9, 12, 9, 9]
    assert steady(passing) is False
    assert steady(passing, passing=True)
    busy = [3, 3, 5, 6, 3, 3, 5, 3, 6, 3, 5, 5, 3, 6, 5, 6]
    assert steady(busy, passing=True), "some come and go, more often towards the end"
    assert steady([*busy[:12], 4, 6, 5, 4], passing=True) is False, "one was never given back"
    missing = [11.0] * 16
    missing[5] = 10.0
    assert steady(missing, passing=True), "one connection was down for a moment"


def test_too_few_samples_say_nothing() -> None:
    assert memory([0.0, 1.0], [5.0, 5.0]) is None
    assert steady([9, 9, 9]) is None


def test_samples_of_this_process_and_of_one_that_is_gone() -> None:
    samples = Samples(0.0, rest=0.0)
    samples.take({"here": os.getpid(), "gone": 2**22 + 1})
    samples.take({"here": os.getpid()})
    assert samples.of.keys() == {"here"}
    assert all(len(samples.of["here"][name]) == 2 for name in ("time", *QUANTITIES))
    assert samples.of["here"]["handles"][0] > 2
    patient = Samples(60.0)
    patient.take({"here": os.getpid()})
    patient.take({"here": os.getpid()})
    assert len(patient.of["here"]["time"]) == 1
