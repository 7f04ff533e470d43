"""Signals at random moments of real processes leave a result, a recording, 130 or 143, and nothing else."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import psutil
import pytest
from mcap.reader import make_reader

from agents.process import FAULT
from deploy.run.options import fresh_run_name
from tests.deploy.processes.ports import free_ports
from tests.scripts import ROOT, ended
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]

COMMAND = (sys.executable, "-m", "disknav")
RUN = ("swap-2", "--quiet", "--speed", "6", "--record", "run.mcap", "--json", "result.json")
TRANSPORTS = ("routed", "local", "mesh")
SIGNALS = (signal.SIGINT, signal.SIGTERM)
_END = 40.0  # s that a command may take to end after a signal, on a machine that does much else
_GONE = 5.0  # s that the kernel and the fork server may take to end the others


class Outcome(NamedTuple):
    status: int
    faults: list[str]


class Victim:
    """A command that runs in a folder of its own; a context manager, which leaves nothing of it.

    Args:
        folder: empty; standard error and output, and temporary files, go there.
        arguments: of the command; one of them is `run`.
        run: a name that no other run has.
    """

    def __init__(self, folder: Path, *arguments: str, run: str) -> None:
        self.run, self.folder = run, folder
        self._temporary = folder / "t"
        self._temporary.mkdir()
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(self._temporary)}
        with (folder / "stderr").open("wb") as said, (folder / "stdout").open("wb") as out:
            self.process = subprocess.Popen(
                [*COMMAND, *arguments],
                cwd=folder,
                env=environment,
                stdout=out,
                stderr=said,
                start_new_session=True,
            )
        self._began = time.monotonic()

    def __enter__(self) -> Victim:
        return self

    def __exit__(self, *_: object) -> None:
        self.signal(signal.SIGKILL, everywhere=True)
        self.process.wait()

    def await_begin(self) -> None:
        """Wait until its own first line has run: before that the process is Python's."""
        until(lambda: self.process.poll() is not None or minds(self.process.pid, signal.SIGTERM), _END)

    def await_life(self, seconds: float) -> None:
        self.await_begin()
        try:
            self.process.wait(max(0.0, seconds))
        except subprocess.TimeoutExpired:
            return

    def signal(self, number: int, *, everywhere: bool = False) -> None:
        """Signal it, or, as a service manager does, all its processes."""
        self.process.send_signal(number)
        for each in self.family() if everywhere else ():
            with suppress(ProcessLookupError):
                os.kill(each, number)

    def family(self) -> list[int]:
        """Processes whose title or command line has the name of the run."""
        found = []
        for each in psutil.process_iter():
            try:
                if each.pid != self.process.pid and any(self.run in word for word in each.cmdline()):
                    found.append(each.pid)
            except psutil.Error:
                continue
        return found

    def left(self, number: int, *, quiet: bool = True) -> Outcome:
        """Wait for its end after a signal; what there must not be, or should be and is not.

        `quiet`: it says nothing on standard error; else it may, but no trace of a failure.
        """
        try:
            status = self.process.wait(_END)
        except subprocess.TimeoutExpired:
            return Outcome(-1, [f"still runs {_END:g} s later"])
        faults = []
        if status not in (128 + number, 0):
            faults.append(f"exit status {status}")
        said = (self.folder / "stderr").read_text(errors="replace").strip()
        if said and (quiet or "Traceback" in said):
            faults.append(f"standard error: {said}")
        deadline = time.monotonic() + _GONE
        while (rest := self.family()) and time.monotonic() < deadline:
            time.sleep(0.02)
        if rest:
            faults.append(f"processes {rest} are left")
        if remains := [each.name for each in self._temporary.iterdir()]:
            faults.append(f"temporary files {remains} are left")
        return Outcome(status, faults)


def minds(pid: int, number: int) -> bool:
    """Whether a process catches a signal, or blocks it until it does."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    masks = [status.partition(f"{name}:\t")[2][:16] for name in ("SigCgt", "SigBlk")]
    return any(int(mask or "0", 16) >> (number - 1) & 1 for mask in masks)


def _recorded(folder: Path, transport: str) -> Victim:
    run = fresh_run_name()
    return Victim(folder, "run", *RUN, "--transport", transport, "--run", run, run=run)


def interrupted(folder: Path, seed: int, span: float, transport: str) -> Outcome:
    """Interrupt a recorded run at a moment drawn from [0, span] s of its life; how it ended.

    `seed`: of the moment, and of which signal is sent, once or twice, to one process or all.
    """
    dice = Random(seed)
    number, twice = dice.choice(SIGNALS), dice.random() < 0.2
    with _recorded(folder, transport) as victim:
        victim.await_life(dice.uniform(0.0, span))
        victim.signal(number, everywhere=dice.random() < 0.3)
        if twice:
            time.sleep(0.05)
            victim.signal(number)
        outcome = victim.left(number)
    return outcome._replace(faults=[*outcome.faults, *_result(folder, outcome.status), *_recording(folder)])


def _result(folder: Path, status: int) -> list[str]:
    try:
        verdict = json.loads((folder / "result.json").read_text())["verdict"]
    except (OSError, ValueError, KeyError) as error:
        return [f"no result: {error!r}"]
    allowed = ("arrived",) if status == 0 else ("arrived", "interrupted")
    return [] if verdict in allowed else [f"verdict {verdict} with status {status}"]


def _recording(folder: Path) -> list[str]:
    """A recording need not have begun; what there is must be closed properly, as stock tools see it. Once a
    tick is over there is a result."""
    path = folder / "run.mcap"
    if not path.exists():
        return []
    try:
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            if reader.get_summary() is None:
                return ["the recording has no summary"]
            names = {each.name for each in reader.iter_metadata()}
            ended = {"result" for _, channel, _ in reader.iter_messages() if channel.topic.endswith("/truth")}
    except Exception as error:  # noqa: BLE001  # whatever a stock reader says
        return [f"the recording cannot be read: {error!r}"]
    return [] if {"recorder"} | ended <= names else [f"the recording has metadata {names} only"]


def _later(seed: int) -> Any:
    return pytest.param(seed, marks=pytest.mark.campaign)


@pytest.fixture
def folder() -> Iterator[Path]:
    """Short enough for the names of sockets."""
    with TemporaryDirectory(prefix="m-") as name:
        yield Path(name)


@cache
def span(transport: str) -> float:
    """How long an undisturbed run takes, s, from the moment when its first line has run."""
    with TemporaryDirectory(prefix="m-") as name, _recorded(Path(name), transport) as victim:
        victim.await_begin()
        began = time.monotonic()
        assert victim.process.wait(120.0) == 0
        return time.monotonic() - began


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 15, *map(_later, range(16, 215))])
def test_a_run_that_is_interrupted_leaves_what_is_promised(seed: int, folder: Path) -> None:
    transport = TRANSPORTS[seed % len(TRANSPORTS)]
    outcome = interrupted(folder, seed, span(transport), transport)
    assert outcome.faults == [], f"seed {seed}"


@pytest.mark.parametrize("seed", [0, *map(_later, range(1, 50))])
def test_single_processes_end_whatever_they_are_doing(seed: int, folder: Path) -> None:
    """Alone and in a run, which may not have begun, and whose router or world may have ended before them."""
    dice = Random(seed)
    (port,) = free_ports(1)
    run, endpoint = fresh_run_name(), f"tcp/127.0.0.1:{port}"
    here = ("--router", endpoint, "--run", run)
    commands = [
        ("node", "router", "--listen", endpoint),
        ("node", "world", "swap-2", "--mode", "realtime", "--set", "control.speed=0.01", *here),
        ("node", "robot", "1", *here),
        ("node", "robot", "2", *here),
        ("monitor", run, "--web", *here[:2]),
    ]
    with ExitStack() as stack:
        victims = []
        for number, command in enumerate(commands):
            own = folder / str(number)
            own.mkdir()
            victims.append(stack.enter_context(Victim(own, *command, run=fresh_run_name())))
            victims[-1].await_begin()
        for victim in dice.sample(victims, len(victims)):
            victim.await_life(dice.uniform(0.0, 1.5))
            number = dice.choice(SIGNALS)
            victim.signal(number)  # if it still runs
            outcome = victim.left(number, quiet=False)
            router, world, *robots, _ = victims
            others = robots if victim is world else {router, world} - {victim}
            lone = any(each.process.poll() is not None for each in others)
            by_itself = [f"exit status {1 if victim is world else FAULT}"] if lone else []
            assert outcome.faults in ([], by_itself), (seed, victim.process.args, outcome)


PROGRAM = """
import disknav, os, signal, threading, time
from protocol.process import signals
signals._HELD_UP = 0.1
class Interrupting:
    calls = 0
    def __init__(self, *_): pass
    def velocity(self, view):
        Interrupting.calls += 1
        if Interrupting.calls == 20: {meanwhile}
        return 0.0, 0.0
def ctrl_c(): os.kill(os.getpid(), signal.SIGINT)
def later(seconds): threading.Timer(seconds, ctrl_c).start()
try: print(disknav.run("swap-2", {{"control.law": "__main__:Interrupting"}}).verdict)
except KeyboardInterrupt: print("interrupted in the law")
try: signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt: print("theirs")
"""


@pytest.mark.parametrize(
    ("meanwhile", "said"),
    [
        ("ctrl_c()", "interrupted\ntheirs\n"),
        ("later(0.1), later(0.5), time.sleep(60.0)", "interrupted in the law\ntheirs\n"),
    ],
    ids=["a law", "a law that is stuck"],
)
def test_in_a_users_program_ctrl_c_ends_the_run_and_then_is_theirs(meanwhile: str, said: str) -> None:
    program = ended(PROGRAM.format(meanwhile=meanwhile), timeout=100.0)
    assert (program.stdout, program.stderr) == (said, "")


def test_a_signal_while_the_command_is_imported_ends_it_without_a_word() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "disknav", "check", "figure-1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    until(lambda: process.poll() is not None or minds(process.pid, signal.SIGTERM))
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=60.0)
    assert (process.returncode, said) == (143, "")


ROBOT = """
import os, runpy, signal, sys
class Last:
    def __del__(self, kill=os.kill, own=os.getpid(), number=signal.SIGTERM): kill(own, number)
sys.last = Last()  # goes when the interpreter itself does
sys.argv[1:] = ["tcp/127.0.0.1:9", "yard", "1", "0.1", *5 * [""]]
runpy.run_module("agents.process", run_name="__main__")
"""


def test_a_robot_that_ends_by_itself_says_why_whatever_comes_meanwhile() -> None:
    assert ended(ROBOT).returncode == FAULT
