"""Signals and Ctrl-C while real processes run: everything ends, and every run has its report."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest

from deploy.library.load import load
from deploy.output.exit_status import EXIT_INTERRUPTED
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, Transport
from protocol.messages import Clock
from tests.deploy.processes.test_spawn import gone
from tests.deploy.telemetry.monitor.watched import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]

DISKNAV = [sys.executable, "-m", "deploy.cli"]


@pytest.mark.parametrize(
    ("number", "times", "starting"),
    [
        (signal.SIGINT, 1, False),
        (signal.SIGTERM, 1, False),
        (signal.SIGINT, 4, False),
        (signal.SIGINT, 2, True),
    ],
)
def test_a_signal_stops_everything_and_leaves_a_result(
    number: int, times: int, starting: bool, tmp_path: Path
) -> None:
    target, recording = tmp_path / "result.json", tmp_path / "run.mcap"
    command = [*DISKNAV, "run", "swap-6", "--mode", "realtime", "--quiet", "--json", str(target)]
    command += ["--record", str(recording), "--set", "control.speed=0.01"]
    process = subprocess.Popen(command, start_new_session=True)
    if starting:
        until(lambda: psutil.Process(process.pid).children(recursive=True))  # the fork server, to begin with
        family = psutil.Process(process.pid).children(recursive=True)
    else:
        family = _wait_for_family(process, recording)
    for _ in range(times):
        process.send_signal(number)
        with suppress(subprocess.TimeoutExpired):
            process.wait(0.1)
    assert process.wait(20.0) == EXIT_INTERRUPTED
    assert json.loads(target.read_text())["verdict"] == "interrupted"
    assert all(gone(each.pid) for each in family)


def interrupt() -> None:
    """As a callback may, rather than the terminal."""
    raise KeyboardInterrupt


@pytest.mark.parametrize("tick", [0, 3])
@pytest.mark.parametrize("transport", ["routed", "mesh"])
def test_ctrl_c_in_the_second_run_leaves_the_report_of_the_first(transport: Transport, tick: int) -> None:
    scenario = load("swap-2")
    first = replace(scenario, time=replace(scenario.time, limit=5 * scenario.time.step))

    interruptions = iter([interrupt if tick else lambda: signal.raise_signal(signal.SIGINT)])

    def watch(clock: Clock) -> None:
        if clock.run_number == 1 and clock.tick >= tick:
            for interruption in interruptions:
                interruption()

    options = RunOptions(transport, speed=1.0)
    with Fleet([first, replace(scenario, name="second")], options, watch=watch) as fleet:
        reports = fleet.execute()
    told = [(report["scenario"], report["run_number"], report["verdict"]) for report in reports]
    assert told == [("swap-2", 0, "timeout"), ("second", 1, "interrupted")]


def test_ctrl_c_while_a_report_is_taken_changes_nothing_about_it() -> None:
    def digest(report: dict[str, Any]) -> dict[str, Any]:
        signal.raise_signal(signal.SIGINT)
        return report

    with Fleet([load("swap-2")], RunOptions("mesh"), digest=digest) as fleet:
        (report,) = fleet.execute()
    assert report["verdict"] == "arrived"


def _wait_for_family(process: subprocess.Popen[bytes], recording: Path) -> list[psutil.Process]:
    """The processes that a command has started, once they make ticks."""
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline:
        if recording.exists() and recording.stat().st_size > 20_000:  # much more than the scenario
            return psutil.Process(process.pid).children(recursive=True)
        assert process.poll() is None, "the command ended by itself"
        time.sleep(0.05)
    raise AssertionError("the fleet did not start")
