"""Fewer pairs are measured, and the smallest gap and all contacts are those of all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from deploy.library.random_instances import random_instance
from protocol.geometry import Disk
from world.judge import nearest
from world.judge.clearance import Disks, Plane, Reals, gaps
from world.judge.nearest import NearestGaps

ROBOTS = 60
STEP = 0.01  # m


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """No number of pairs is so small that all are measured."""
    monkeypatch.setattr(nearest, "FEW", 0)


def setting() -> tuple[Disks, Plane]:
    scenario = random_instance(ROBOTS, 1)
    return Disks(scenario), np.array([complex(*spec.start) for spec in scenario.robots])


def negative(disks: Disks, found: Reals) -> list[tuple[int, tuple[int, int], float]]:
    return [(row, disks.names(index), found[row, index]) for row, index in np.argwhere(found < 0.0).tolist()]


def assert_same(measured: tuple[Disks, Reals], disks: Disks, before: Plane, after: Plane) -> None:
    some, found = measured
    wanted = gaps(disks, before, after)
    assert found.min(axis=-1).tolist() == wanted.min(axis=-1).tolist()
    assert negative(some, found) == negative(disks, wanted)


def test_what_matters_is_measured_while_disks_wander_and_overlap() -> None:
    disks, places = setting()
    measure, random, fewer = NearestGaps(disks), np.random.default_rng(0), 0
    contacts = 0
    for _ in range(100):
        steps = STEP * np.exp(2j * np.pi * random.uniform(size=(2, ROBOTS)))
        path = np.stack((places, places + steps[0], places + steps[0] + steps[1]))
        some, found = measure(path[:2], path[1:])
        assert_same((some, found), disks, path[:2], path[1:])
        fewer += len(some.contact) < len(disks.contact) / 3
        contacts += len(negative(some, found))
        places = path[-1]
    assert fewer == 100
    assert contacts > 0


def test_all_are_measured_where_somebody_leaps() -> None:
    disks, places = setting()
    measure = NearestGaps(disks)
    measure(places[None], places[None])
    after = places.copy()
    after[0] = places[int(np.abs(places - places[0]).argmax())]
    assert_same(measure(places[None], after[None]), disks, places[None], after[None])


def test_all_are_measured_where_nobody_is_near() -> None:
    disks, places = setting()
    far = 100.0 * places
    assert_same(NearestGaps(disks)(far[None], far[None]), disks, far[None], far[None])


def test_things_that_come_are_seen() -> None:
    disks, places = setting()
    measure = NearestGaps(disks)
    measure(places[None], places[None])
    disks.surround({7: Disk(places[3].real, places[3].imag, 0.05)})
    some, found = measure(places[None], places[None])
    assert (0, (-7, 4)) in [each[:2] for each in negative(some, found)]
    assert_same((some, found), disks, places[None], places[None])
