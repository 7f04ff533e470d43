"""The fork server beside libraries that start processes: the least of several rounds, and its ratio.

The time until so many processes have imported what a robot imports and say so, from nothing, and the private
memory of each, MB: by the fork server, by that of `multiprocessing`, and by an interpreter for each, which is
what circus, supervisord and subprocess do.

    python -m tests.benchmarks.libraries --processes 32
"""

from __future__ import annotations

import argparse
import multiprocessing
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection as Pipe
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import psutil

from deploy.processes.spawn import MODULES, Spawner, environment
from deploy.processes.supervisor import Supervisor
from deploy.processes.table import Process

_HERE = "tests.benchmarks.libraries"


class Started(NamedTuple):
    """Of several processes: s until all are up, and private memory of each, MB."""

    seconds: float
    private_mb: float


def own_start(count: int) -> Started:
    """By the fork server, until each process has said a word."""
    began = time.perf_counter()
    with Supervisor(Spawner((*MODULES, _HERE))) as supervisor:
        rows = [Process(f"idle-{n}", f"{_HERE}:idle", reports=True) for n in range(count)]
        supervisor.start(rows)
        for row in rows:
            supervisor.report(row.name, 60.0)
        return Started(time.perf_counter() - began, _private(list(supervisor.pids().values())))


def library_start(count: int) -> Started:
    """By the fork server of `multiprocessing`, a new one each time."""
    with TemporaryDirectory() as folder:
        script = Path(folder) / "start.py"
        script.write_text(
            f"from {_HERE} import forkserver\nif __name__ == '__main__':\n    forkserver({count})\n"
        )
        call = [sys.executable, str(script)]
        done = subprocess.run(call, env=_environment(), capture_output=True, text=True, check=True)
        return Started(*map(float, done.stdout.split()))


def forkserver(count: int) -> None:
    """Print what `library_start` measures."""
    began = time.perf_counter()
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*MODULES, _HERE])
    ours, theirs = zip(*(context.Pipe() for _ in range(count)), strict=True)
    processes = [context.Process(target=wait_for_end, args=(pipe,), daemon=True) for pipe in theirs]
    for process in processes:
        process.start()
    for pipe in ours:
        pipe.recv()
    seconds = time.perf_counter() - began
    print(seconds, _private([process.pid or 0 for process in processes]))


def interpreters(count: int) -> Started:
    """By an interpreter for each."""
    imports = "; ".join(f"import {module}" for module in MODULES)
    code = f"{imports}; print(flush=True); input()"
    call = [sys.executable, "-c", code]
    began = time.perf_counter()
    started = [
        subprocess.Popen(call, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=_environment())
        for _ in range(count)
    ]
    for process in started:
        assert process.stdout is not None
        process.stdout.readline()
    found = Started(time.perf_counter() - began, _private([process.pid for process in started]))
    for process in started:
        process.communicate(b"\n")
    return found


def idle(ready: Callable[[str], None]) -> int:
    """A process that is up and waits for its end."""
    ready("up")
    while True:
        time.sleep(3600.0)


def wait_for_end(pipe: Pipe) -> None:
    """The same for `multiprocessing`."""
    pipe.send("up")
    with suppress(EOFError):
        pipe.recv()


def _environment() -> dict[str, str]:
    return {**environment(), "PYTHONPATH": str(Path.cwd())}


def _private(pids: list[int]) -> float:
    return sum(float(psutil.Process(pid).memory_full_info().uss) for pid in pids) / len(pids) / 2**20


def lines(processes: int, rounds: int) -> list[str]:
    """The table."""
    starts = {"fork server": own_start, "multiprocessing": library_start, "interpreters": interpreters}
    each_round = [{name: way(processes) for name, way in starts.items()} for _ in range(rounds)]
    started = {name: min(each[name] for each in each_round) for name in starts}
    table = [f"{f'{processes} processes up, s':<20}{'':>8}{'ratio':>8}{'private MB':>12}"]
    floor = started["multiprocessing"].seconds
    table += [
        f"{name:<20}{each.seconds:>8.2f}{each.seconds / floor:>8.2f}{each.private_mb:>12.1f}"
        for name, each in started.items()
    ]
    return table


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--processes", type=int, default=32)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    print("\n".join(lines(options.processes, options.rounds)), flush=True)


if __name__ == "__main__":
    main()
