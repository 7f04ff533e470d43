"""Robots that wait for each other stay on a core each; the system places everybody else."""

from __future__ import annotations

import os
import sys

import psutil
import pytest

from deploy.library.load import load
from deploy.processes.cores import core_of
from deploy.run.fleet import Fleet
from deploy.run.options import Mode, RunOptions
from protocol.messages import Clock

linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere no process is bound to a core")


@linux
def test_robots_are_dealt_out_among_the_cores_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {5, 2})
    assert [core_of(turn, 5) for turn in range(5)] == [2, 5, 2, 5, 2]


@linux
def test_with_few_for_each_core_the_system_chooses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2, 3})
    assert core_of(0, 7) is None
    assert core_of(0, 8) == 0


@linux
@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_only_robots_in_lockstep_are_bound(monkeypatch: pytest.MonkeyPatch, mode: Mode) -> None:
    everywhere = os.sched_getaffinity(0)
    core = min(everywhere)
    monkeypatch.setattr("deploy.run.assembly.core_of", lambda _, robots: core if robots else None)
    seen: dict[bool, list[set[int]]] = {True: [], False: []}

    def look(clock: Clock) -> None:
        if clock.tick and not seen[True]:
            for process in psutil.Process().children(recursive=True):
                is_robot = " ".join(process.cmdline()).startswith("disknav robot")
                seen[is_robot].append(set(process.cpu_affinity()))

    with Fleet([load("swap-2")], RunOptions(mode=mode), watch=look) as fleet:
        fleet.execute(enough=lambda: bool(seen[True]))
    assert seen[True] == [{core} if mode == "lockstep" else everywhere] * 2
    assert seen[False]
    assert all(cores == everywhere for cores in seen[False])


@linux
@pytest.mark.process
@pytest.mark.timeout(60)
def test_a_core_that_is_not_there_costs_nothing_but_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deploy.run.assembly.core_of", lambda *_: 1023)
    with Fleet([load("swap-2")], RunOptions()) as fleet:
        assert [result["verdict"] for result in fleet.execute()] == ["arrived"]
