"""What it costs a fleet to be recorded and watched: the same lock-step run with and without, in turns.

`page` is `disknav monitor --web` with one viewer attached, `terminal` is `disknav monitor`; both are
there before the run begins. Rates are ticks per second of wall time, ratios are to `plain`.

    python -m tests.benchmarks.recording.recorder --rounds 5
"""

from __future__ import annotations

import argparse
import os
import pty
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import psutil
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, fresh_run_name
from protocol.bus.connection import Connection
from protocol.scenario.model import Scenario

VARIANTS = ("plain", "recorded", "page", "terminal")
SETTINGS = ("control.speed=0.01", "time.limit=120")
_PATIENCE = 10.0

Watcher = Callable[[str, str], AbstractContextManager[Callable[[], float]]]  # endpoint, run -> s of CPU


class Cost(NamedTuple):
    """Of one run: ticks per second, and processor time of all processes per tick (ms), router and
    whoever records or watches included."""

    ticks_per_second: float
    cpu_ms: float


def cost(scenario: Scenario, variant: str) -> Cost:
    """Run `scenario` once."""
    if variant in _WATCHERS:
        return _watched(scenario, _WATCHERS[variant])
    with TemporaryDirectory(prefix="disknav-") as folder:
        record = Path(folder) / "run.mcap" if variant == "recorded" else None
        with Fleet(scenario, RunOptions(run=fresh_run_name()), record=record) as fleet:
            report = fleet.execute()
            return _cost(report, (process["cpu_s"] for process in fleet.processes()))


def _watched(scenario: Scenario, watcher: Watcher) -> Cost:
    """With a router of its own, so that somebody can be there before the run."""
    run = fresh_run_name()
    with Supervisor() as router:
        router.start([table.router(Connection("router"))])
        endpoint = router.report("router", _PATIENCE)
        with watcher(endpoint, run) as used:
            with Fleet(scenario, RunOptions(router=endpoint, run=run)) as fleet:
                report = fleet.execute()
                watching, processes = used(), fleet.processes()
            router.stop()
            cpu = [process["cpu_s"] for process in processes]
            return _cost(report, [watching, *cpu, *(usage.cpu_s for usage in router.usage())])


def _cost(report: dict[str, Any], cpu: Iterable[float]) -> Cost:
    ticks = report["ticks"]
    return Cost(ticks / report["wall_time"], 1000.0 * sum(cpu) / ticks)


# -- those who watch; each gives a function that says how much processor time it took, s


@contextmanager
def _page(endpoint: str, run: str) -> Iterator[Callable[[], float]]:
    with _monitor(endpoint, run, "--web", stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        address = process.stdout.readline().decode().split()[0]
        with connect(address.replace("http", "ws").replace("/#", "/live?token=")) as viewer:
            threading.Thread(target=_view, args=(viewer.recv,), daemon=True).start()
            yield _meter(process)


@contextmanager
def _terminal(endpoint: str, run: str) -> Iterator[Callable[[], float]]:
    screen, end = pty.openpty()
    with _monitor(endpoint, run, stdout=end) as process:
        os.close(end)
        os.read(screen, 1)  # it shows something
        threading.Thread(target=_view, args=(lambda: os.read(screen, 65536),), daemon=True).start()
        yield _meter(process)


_WATCHERS: dict[str, Watcher] = {"page": _page, "terminal": _terminal}


@contextmanager
def _monitor(endpoint: str, run: str, *options: str, stdout: int) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-m", "disknav", "monitor", run, "--router", endpoint, *options]
    process = subprocess.Popen(
        command, stdout=stdout, stderr=subprocess.DEVNULL, env={**os.environ, "TERM": "xterm"}
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(_PATIENCE)
        finally:
            process.kill()
            if process.stdout is not None:
                process.stdout.close()


def _view(receive: Callable[[], object]) -> None:
    with suppress(ConnectionClosed, OSError):
        while receive():
            pass


def _meter(process: subprocess.Popen[bytes]) -> Callable[[], float]:
    """Processor time from now on."""
    watched = psutil.Process(process.pid)

    def used() -> float:
        with suppress(psutil.Error):
            times = watched.cpu_times()
            return float(times.user + times.system)
        return 0.0

    before = used()
    return lambda: max(0.0, used() - before)


def lines(costs: dict[str, list[Cost]]) -> Iterator[str]:
    """One line a variant: medians, and medians of the ratios to `plain` in the same round."""
    for variant, each in costs.items():
        rounds = list(zip(each, costs["plain"], strict=True))
        rate, cpu = (median(column) for column in zip(*each, strict=True))
        slower = median(own.ticks_per_second / plain.ticks_per_second for own, plain in rounds)
        dearer = median(own.cpu_ms / plain.cpu_ms for own, plain in rounds)
        yield f"{variant:<10}{rate:9.0f}{slower:8.3f}{cpu:13.2f}{dearer:8.3f}"


def main() -> None:
    """Print medians; the variants take turns, so that a busy machine treats them alike."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenario", default="figure-1")
    parser.add_argument("--set", nargs="*", default=SETTINGS, help="over the scenario's", dest="settings")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--variants", nargs="+", choices=VARIANTS[1:], default=VARIANTS[1:])
    options = parser.parse_args()
    scenario = load(options.scenario, options.settings)
    costs: dict[str, list[Cost]] = {variant: [] for variant in ("plain", *options.variants)}
    for _ in range(options.rounds):
        for variant, each in costs.items():
            each.append(cost(scenario, variant))
    print(
        f"{'':<10}{'ticks/s':>9}{'ratio':>7}{'fleet cpu ms':>12}{'ratio':>7}{'watcher cpu ms':>14}{'all':>7}"
    )
    for line in lines(costs):
        print(line, flush=True)


if __name__ == "__main__":
    main()
