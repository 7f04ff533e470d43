"""Certificates on a Dask cluster: the branching of one machine."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("distributed")

from distributed import LocalCluster

from deploy.library.load import read
from deploy.software import scheduler as reached
from deploy.theory.certify import spread
from deploy.theory.certify.campaign import Here, prove
from deploy.theory.certify.certificate import Certificate, Goals
from protocol.errors import ProcessError

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address=":0", silence_logs=50
    ) as cluster:
        yield cluster.scheduler_address


def test_the_branching_is_that_of_one_machine(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spread, "_NODES", 200)  # many tasks
    goals = Goals.of(read("figure-2"))
    here, there = Certificate(goals), Certificate(goals)
    prove(here, 3000.0, Here(), lambda _: True)
    prove(there, 3000.0, spread.Spread(scheduler), lambda _: True)
    assert [slab.branching for slab in there.slabs] == [slab.branching for slab in here.slabs]
    assert there.time > 0.0


def test_a_cluster_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reached, "_REACHING", 0.3)
    with pytest.raises(ProcessError, match=r"127\.0\.0\.1:1"):
        spread.Spread("tcp://127.0.0.1:1")
