"""Processes are started fast, leave no orphans, and are scheduled as asked."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from deploy.library.load import load
from deploy.processes.fork_server import FAULT, end_with_pipe
from deploy.processes.spawn import (
    Exited,
    News,
    Report,
    Scheduling,
    Spawner,
    Started,
    core_of,
    require_realtime,
)
from deploy.processes.table import RECORDER
from deploy.run.fleet import Fleet
from deploy.run.options import Mode, RunOptions
from protocol.errors import ProcessError, UsageError
from protocol.messages import Clock
from protocol.scenario.model import Order, RobotSpec
from tests.deploy.processes import children


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

    with Fleet(load("swap-2"), RunOptions(mode=mode), watch=look) as fleet:
        fleet.execute(enough=lambda: bool(seen[True]))
    assert seen[True] == [{core} if mode == "lockstep" else everywhere] * 2
    assert seen[False]
    assert all(cores == everywhere for cores in seen[False])


@linux
@pytest.mark.process
@pytest.mark.timeout(60)
def test_a_core_that_is_not_there_costs_nothing_but_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deploy.run.assembly.core_of", lambda *_: 1023)
    with Fleet(load("swap-2"), RunOptions()) as fleet:
        assert fleet.execute()["verdict"] == "arrived"


def refuse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Be a system that allows no real-time priority."""

    def refused(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refused)


@linux
@pytest.mark.process
@pytest.mark.parametrize("transport", ["routed", "mesh"])
def test_where_it_is_not_allowed_nothing_starts_and_the_error_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, transport: str
) -> None:
    refuse(monkeypatch)
    options = RunOptions(transport, "realtime", realtime_priority=True)  # type: ignore[arg-type]
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


def test_it_is_for_linux(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    with pytest.raises(UsageError, match="Linux only"):
        require_realtime()


@needs_realtime
def test_who_asks_stays_as_it_is() -> None:
    before = os.sched_getscheduler(0)
    require_realtime()
    assert os.sched_getscheduler(0) == before


def policies(pid: int) -> set[tuple[int, int]]:
    """Policy and priority of all threads of a process."""
    threads = [int(task.name) for task in Path(f"/proc/{pid}/task").iterdir()]
    return {(os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority) for thread in threads}


@needs_realtime
@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("transport", ["routed", "mesh"])
def test_world_router_and_robots_go_first_in_every_life_and_nobody_else(
    tmp_path: Path, transport: str
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

    options = RunOptions(transport, "realtime", restarts=1, realtime_priority=True)  # type: ignore[arg-type]
    with Fleet(scenario, options, watch=look, record=tmp_path / "run.mcap") as fleet:
        fleet.execute(enough=lambda: bool(seen))
    first = {"world", "robot-1", "robot-2", "robot-3", *(["router"] if transport == "routed" else [])}
    assert {name for name, these in seen.items() if these == {(os.SCHED_RR, 1)}} == first
    ordinary = {name for name, these in seen.items() if these == {(os.SCHED_OTHER, 0)}}
    assert ordinary == {RECORDER, "server", "launcher"} == seen.keys() - first


pytestmark = [pytest.mark.process, pytest.mark.timeout(60)]

PATIENCE = 20.0  # s


@pytest.fixture
def spawner() -> Iterator[Spawner]:
    with closing(children.spawner()) as spawner:
        yield spawner


def until_exit(spawner: Spawner) -> list[News]:
    """News of the one process, up to its end."""
    heard: list[News] = []
    deadline = time.monotonic() + PATIENCE
    while not any(isinstance(news, Exited) for news in heard):
        assert time.monotonic() < deadline
        heard += spawner.news(1.0)
    return heard


def exit_code(spawner: Spawner) -> int:
    """Exit code of the one process, once it has ended."""
    last = until_exit(spawner)[-1]
    assert isinstance(last, Exited)
    return last.code


def gone(pid: int) -> bool:
    """Wait until a process is no more, or dead and not yet waited for; False if it goes on."""
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.005)
    return False


def test_the_exit_status_is_what_the_function_returns(spawner: Spawner) -> None:
    life = spawner.start("one", "tests.deploy.processes.children:give", (7,))
    started, exited = until_exit(spawner)
    assert isinstance(started, Started)
    assert isinstance(exited, Exited)
    assert (started.life, exited.life, exited.code) == (life, life, 7)
    assert exited.max_rss_mb > 1.0


def test_a_failure_leaves_its_traceback(capfd: pytest.CaptureFixture[str]) -> None:
    with closing(children.spawner()) as spawner:  # whose standard error is that of this test
        spawner.start("calculator", "tests.deploy.processes.children:divide_by_zero")
        assert exit_code(spawner) == FAULT
        printed = capfd.readouterr().err
        assert "calculator: failed:\nTraceback" in printed
        assert "return 1 / 0" in printed


def test_an_error_of_our_own_is_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    with closing(children.spawner()) as spawner:  # whose standard error is that of this test
        spawner.start("radio", "tests.deploy.processes.children:fail_politely")
        assert exit_code(spawner) == FAULT
        assert capfd.readouterr().err == "radio: the cable is unplugged\n"


def test_an_unknown_entry_is_a_failure_of_that_process_alone(spawner: Spawner) -> None:
    spawner.start("nobody", "tests.deploy.processes.children:nothing")
    assert exit_code(spawner) == FAULT
    spawner.start("one", "tests.deploy.processes.children:give", (0,))
    assert exit_code(spawner) == 0


def test_a_process_reports_and_all_its_output_goes_to_standard_error(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with closing(children.spawner()) as spawner:  # whose standard error is that of this test
        spawner.start("one", "tests.deploy.processes.children:print_and_report", reports=True)
        texts = [news.text for news in until_exit(spawner) if isinstance(news, Report)]
        assert texts == ["reported"]
        printed = capfd.readouterr()
        assert (printed.out, printed.err) == ("", "printed\n")


def test_a_signal_shows_as_a_negative_exit_status(spawner: Spawner) -> None:
    life = spawner.start("one", "tests.deploy.processes.children:wait")
    spawner.signal(life, signal.SIGKILL)
    assert exit_code(spawner) == -signal.SIGKILL
    spawner.signal(life, signal.SIGKILL)  # nobody is hit


def test_processes_are_out_of_reach_of_the_terminal(spawner: Spawner) -> None:
    spawner.start("one", "tests.deploy.processes.children:wait")
    (started,) = spawner.news(PATIENCE)
    assert isinstance(started, Started)
    assert os.getsid(started.pid) != os.getsid(0)
    assert os.getpgid(started.pid) != os.getpgid(0)


def test_closing_leaves_nobody(spawner: Spawner) -> None:
    spawner.start("one", "tests.deploy.processes.children:wait")
    (started,) = spawner.news(PATIENCE)
    assert isinstance(started, Started)
    spawner.close()
    assert gone(started.pid)


def test_a_dead_fork_server_takes_all_with_it_and_is_named() -> None:
    with closing(children.spawner()) as spawner:
        life = spawner.start("one", "tests.deploy.processes.children:wait")
        (started,) = spawner.news(PATIENCE)
        assert isinstance(started, Started)
        os.kill(psutil.Process(started.pid).ppid(), signal.SIGKILL)
        assert gone(started.pid)
        with pytest.raises(ProcessError, match="fork server"):
            list(spawner.news(PATIENCE))
        with pytest.raises(ProcessError, match="fork server"):
            spawner.signal(life, signal.SIGTERM)


@pytest.mark.parametrize("frozen", [False, True])
def test_no_orphans_when_the_supervisor_is_killed(tmp_path: Path, frozen: bool) -> None:
    path = tmp_path / "pids"
    code = f"from tests.deploy.processes.children import supervise; supervise({str(path)!r}, ['a', 'b', 'c'])"
    supervisor = subprocess.Popen([sys.executable, "-c", code])
    deadline = time.monotonic() + PATIENCE
    while not path.exists():
        assert time.monotonic() < deadline
        assert supervisor.poll() is None
        time.sleep(0.005)
    pids = [int(pid) for pid in path.read_text().split()]
    assert len(pids) == 3
    if frozen:
        os.kill(pids[0], signal.SIGSTOP)
    supervisor.kill()
    supervisor.wait()
    assert all(map(gone, pids))


def test_without_help_of_the_kernel_a_pipe_ends_a_process() -> None:
    reading, writing = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(writing)
        end_with_pipe(reading)
        children.wait()
    os.close(reading)
    os.close(writing)
    assert os.waitpid(pid, 0)[1] == signal.SIGKILL
