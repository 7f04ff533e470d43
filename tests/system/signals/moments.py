"""Sends a signal to a command at a random moment of its life, and looks at what is left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from typing import NamedTuple
from uuid import uuid4

import psutil
from mcap.reader import make_reader

ROOT = Path(__file__).parents[3]
COMMAND = (sys.executable, "-m", "disknav")
RUN = ("swap-2", "--quiet", "--record", "run.mcap", "--json", "result.json")
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
        for each in [self.process.pid, *self.family()]:
            try:
                os.kill(each, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.process.wait()

    def await_begin(self) -> None:
        """Wait until its own first line has run: before that the process is Python's."""
        while self.process.poll() is None and not minds(self.process.pid, signal.SIGTERM):
            time.sleep(0.001)

    def await_life(self, seconds: float) -> None:
        self.await_begin()
        try:
            self.process.wait(max(0.0, seconds))
        except subprocess.TimeoutExpired:
            return

    def signal(self, number: int) -> None:
        self.process.send_signal(number)

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


def life(folder: Path, transport: str) -> float:
    """How long an undisturbed run takes, s, from the moment when its first line has run."""
    with _recorded(folder, transport) as victim:
        victim.await_begin()
        began = time.monotonic()
        assert victim.process.wait(120.0) == 0
        return time.monotonic() - began


def fresh_name() -> str:
    return f"moment-{uuid4().hex[:12]}"


def _recorded(folder: Path, transport: str) -> Victim:
    run = fresh_name()
    return Victim(folder, "run", *RUN, "--transport", transport, "--run", run, run=run)


def interrupted(folder: Path, seed: int, span: float, transport: str) -> Outcome:
    """Interrupt a recorded run at a moment drawn from [0, span] s of its life; how it ended.

    Args:
        folder: empty; what is left stays there.
        seed: of the moment, and of which signal is sent, once or twice.
        span: length of an undisturbed life, s.
        transport: of the run.
    """
    dice = Random(seed)
    number, twice = dice.choice(SIGNALS), dice.random() < 0.2
    with _recorded(folder, transport) as victim:
        victim.await_life(dice.uniform(0.0, span))
        victim.signal(number)
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
    """A recording need not have begun; what there is must be closed properly, as stock tools see it."""
    path = folder / "run.mcap"
    if not path.exists():
        return []
    try:
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True)
            if reader.get_summary() is None:
                return ["the recording has no summary"]
            names = {each.name for each in reader.iter_metadata()}
            for _ in reader.iter_messages():
                pass
    except Exception as error:  # noqa: BLE001  # whatever a stock reader says
        return [f"the recording cannot be read: {error!r}"]
    return [] if "recorder" in names else [f"the recording has metadata {names} only"]
