"""What watching a crowd comes to: the page in Chromium, the terminal's table, a recording and its plot.

The crowd never rests, and runs in this process at the speed of the wall clock. `frames` is how many the page
was sent in a second, `drawn` how often Chromium asked it to draw; `late` is the longest time (ms) between two
drawings.

    python -m tests.benchmarks.watching --robots 200 --seconds 20
"""

from __future__ import annotations

import argparse
import io
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from rich.console import Console

from deploy.run.local import LocalFleet
from deploy.telemetry.monitor.terminal import table
from protocol.scenario.model import Network, Scenario
from tests.benchmarks.crowds import restless
from tests.deploy.telemetry.monitor.watched import PATIENCE, running, served, until, watch_local

_CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
_FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-sync")
_LOOKS = 20  # at the terminal's table
_COUNTING = """() => {
  const drawn = (window.drawn = { count: 0, late: 0, last: performance.now() });
  const draw = (now) => {
    drawn.count += 1;
    drawn.late = Math.max(drawn.late, now - drawn.last);
    drawn.last = now;
    requestAnimationFrame(draw);
  };
  requestAnimationFrame(draw);
}"""


class Page(NamedTuple):
    """Of a page: frames received and drawn in a second, and the longest time between two drawings, ms."""

    frames: float
    drawn: float
    late: float


def page(scenario: Scenario, seconds: float) -> Page:
    """Watch a fleet in Chromium for so long."""
    from playwright.sync_api import sync_playwright

    chromium = next(path for path in map(shutil.which, _CHROMIUM) if path)
    fleet, frames = LocalFleet(scenario, "watched"), list[float]()
    watcher = watch_local(fleet.network, "watched", speed=1.0)
    with sync_playwright() as driver, served(watcher) as server:
        browser = driver.chromium.launch(executable_path=chromium, args=list(_FLAGS))
        seen = browser.new_page(viewport={"width": 1280, "height": 860})
        seen.on(
            "websocket",
            lambda it: it.on("framereceived", lambda _: frames.append(time.monotonic())),
        )
        seen.goto(server.link)
        with running(fleet):
            seen.wait_for_selector("#robots tr", state="attached", timeout=1000 * PATIENCE)
            seen.wait_for_timeout(2000)
            seen.evaluate(_COUNTING)
            before, began = len(frames), time.monotonic()
            seen.wait_for_timeout(1000 * seconds)
            took, count = time.monotonic() - began, len(frames) - before
            drawn = seen.evaluate("window.drawn")
        browser.close()
    return Page(count / took, drawn["count"] / took, drawn["late"])


def terminal(scenario: Scenario) -> float:
    """Time that the terminal takes for one look, s."""
    fleet = LocalFleet(scenario, "watched")
    watcher = watch_local(fleet.network, "watched", speed=1.0)
    console = Console(file=io.StringIO(), force_terminal=True, width=120, height=60)
    with running(fleet):
        until(lambda: watcher.snapshot()["tick"] > 5)
        began = time.thread_time()
        for _ in range(_LOOKS):
            console.print(table(watcher.snapshot()))
        return (time.thread_time() - began) / _LOOKS


def run(scenario: Scenario, record: Path | None = None) -> float:
    """Wall time of the whole run as fast as can be, s."""
    began = time.perf_counter()
    with LocalFleet(scenario, "watched", record=record) as fleet:
        report = fleet.execute()
        if record is not None:
            fleet.record(report)
    return time.perf_counter() - began


def plot(recording: Path) -> float:
    """Wall time of `disknav recording plot`, s."""
    command = [sys.executable, "-m", "disknav", "recording", "plot", str(recording), "-o"]
    began = time.perf_counter()
    subprocess.run([*command, str(recording.with_suffix(".png"))], check=True, capture_output=True)
    return time.perf_counter() - began


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=200)
    parser.add_argument("--rate", type=float, default=10.0, help="ticks per simulated second")
    parser.add_argument("--seconds", type=float, default=20.0, help="that the page is watched")
    parser.add_argument("--recorded", type=float, default=60.0, help="s of simulated time to record and plot")
    chosen = parser.parse_args(arguments)
    ever = restless(chosen.robots, chosen.rate, 1e4, Network())
    seen = page(ever, chosen.seconds)
    print(f"page      {seen.frames:.1f} frames/s, {seen.drawn:.1f} drawn/s, {seen.late:.0f} ms late")
    print(f"terminal  {1000.0 * terminal(ever):.1f} ms a look, one in 500 ms", flush=True)
    with TemporaryDirectory(prefix="disknav-") as folder:
        recording = Path(folder) / "crowd.mcap"
        some = restless(chosen.robots, chosen.rate, chosen.recorded, Network())
        plain, recorded = run(some), run(some, recording)
        megabytes = recording.stat().st_size / 1e6
        print(f"recording {recorded / plain:.2f} times the time of the run, {megabytes:.1f} MB", flush=True)
        print(f"plot      {plot(recording):.1f} s")


if __name__ == "__main__":
    main()
