"""Robots that wait for each other stay on a core each, and a fleet in real time may go before everybody else;
the system places and orders all others."""

from __future__ import annotations

import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from deploy.library.load import load
from deploy.processes.spawn import Scheduling, core_of, require_realtime
from deploy.processes.table import RECORDER
from deploy.run.fleet import Fleet
from deploy.run.options import Mode, RunOptions
from protocol.errors import UsageError
from protocol.messages import Clock
from protocol.scenario.model import Order, RobotSpec


def unable() -> str | None:
    """Why no process has real-time priority here; None if it may."""
    try:
        return require_realtime()
    except UsageError as error:
        return str(error)


linux = pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system places and orders all")
needs_realtime = pytest.mark.skipif(unable() is not None, reason=unable() or "")


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

    slowly = RunOptions(mode=mode, speed=1.0)  # else it may be over before it is looked at
    with Fleet(load("swap-2"), slowly, watch=look) as fleet:
        fleet.execute(enough=lambda: bool(seen[True]))
    assert seen[True] == [{core} if mode == "lockstep" else everywhere] * 2
    assert seen[False]
    assert all(cores == everywhere for cores in seen[False])


def refuse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Be a system that allows no real-time priority."""

    def refused(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refused)


@linux
@pytest.mark.process
def test_where_it_is_not_allowed_nothing_starts_and_the_error_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    refuse(monkeypatch)
    options = RunOptions(mode="realtime", realtime_priority=True)
    before = psutil.Process().children()
    with pytest.raises(
        UsageError, match=r"not permitted.*ulimit -r.*LimitRTPRIO.*SYS_NICE.*leave the option"
    ):
        Fleet(load("swap-2"), options, record=tmp_path / "run.mcap").__enter__()
    assert psutil.Process().children() == before
    assert list(tmp_path.iterdir()) == []


@linux
def test_a_process_that_is_refused_does_not_go_on_without(monkeypatch: pytest.MonkeyPatch) -> None:
    refuse(monkeypatch)
    with pytest.raises(UsageError, match="not permitted"):
        Scheduling(realtime=True).apply()


def policies(pid: int) -> set[tuple[int, int]]:
    """Policy and priority of all threads of a process."""
    threads = [int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()]
    return {(os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority) for thread in threads}


def test_it_is_for_linux(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    with pytest.raises(UsageError, match="Linux only"):
        require_realtime()


@needs_realtime
@pytest.mark.process
@pytest.mark.timeout(60)
def test_world_router_and_robots_go_first_in_every_life_and_nobody_else(
    tmp_path: Path,
) -> None:
    guest = RobotSpec(3, 0.03, (0.0, 0.15), (0.0, -0.15))
    scenario = load("swap-2", ["control.speed=0.01", "time.limit=40"])
    scenario = replace(scenario, orders=(Order(0.1, add=guest),))
    killed: list[int] = []
    seen: dict[str, set[tuple[int, int]]] = {}

    def look(clock: Clock) -> None:
        pids = fleet.pids()
        if clock.tick > 5 and not killed:
            killed.append(pids["robot-1"])
            fleet.signal("robot-1", signal.SIGKILL)
        reborn = killed and pids.get("robot-1", killed[0]) != killed[0]
        ready = reborn and policies(pids["robot-1"]) == {(os.SCHED_RR, 1)}  # it may just have begun
        if ready and {1, 3} <= set(clock.active) and not seen:
            seen.update({name: policies(pid) for name, pid in pids.items()})
            server = psutil.Process(pids["world"]).ppid()
            seen.update(server=policies(server), launcher=policies(os.getpid()))

    options = RunOptions(mode="realtime", restarts=1, realtime_priority=True)
    with Fleet(scenario, options, watch=look, record=tmp_path / "run.mcap") as fleet:
        fleet.execute(enough=lambda: bool(seen))
    first = {"world", "robot-1", "robot-2", "robot-3", "router"}
    assert {name for name, these in seen.items() if these == {(os.SCHED_RR, 1)}} == first
    ordinary = {name for name, these in seen.items() if these == {(os.SCHED_OTHER, 0)}}
    assert ordinary == {RECORDER, "server", "launcher"} == seen.keys() - first
