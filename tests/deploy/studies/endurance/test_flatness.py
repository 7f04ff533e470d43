"""When memory, handles and threads count as flat."""

from __future__ import annotations

import os

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


def test_counts() -> None:
    assert steady([9, 9, 10, 11, 11, 11, 11, 11])
    assert steady([9, 9, 11, 10, 9, 9, 10, 10])
    assert steady([9, 9, 10, 10, 10, 10, 10, 11]) is False


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
