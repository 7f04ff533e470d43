"""Ctrl-C while a run is put together, says its last words, and is taken down."""

from __future__ import annotations

import json
import signal
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from deploy.library.load import load
from deploy.output.exit_status import EXIT_INTERRUPTED
from deploy.run import execute as execution
from deploy.run.execute import Extras, execute
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.telemetry.recording.reading.reader import read
from deploy.telemetry.recording.recorder import Recorder
from protocol.errors import RecordingError
from tests.scripts import ended
from world.shell.node import WorldNode

SWAP = load("swap-2")


def ctrl_c(*_: object) -> None:
    signal.raise_signal(signal.SIGINT)


def _run(tmp_path: Path, **options: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """What is returned, and what is written."""
    target = tmp_path / "result.json"
    result = execute(SWAP, RunOptions("local"), Extras(json=target, **options), quiet=True)
    return result, json.loads(target.read_text())


@pytest.mark.process
@pytest.mark.parametrize("moment", ["LocalFleet.start", "FaultSchedule.__init__"])
def test_as_a_recorded_run_is_put_together(moment: str, tmp_path: Path) -> None:
    """Who writes closes the file by itself, and the command waits for that."""
    _interrupted(moment, "pass", tmp_path)
    with (tmp_path / "run.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_summary() is not None
        (end,) = reader.iter_metadata()
    assert (end.name, end.metadata["messages"]) == ("recorder", "0")
    with pytest.raises(RecordingError, match="was cut before it began"):
        read(tmp_path / "run.mcap")


@pytest.mark.process
def test_as_a_recorded_run_is_put_together_and_its_disk_is_stuck(tmp_path: Path) -> None:
    stuck = "(writer,) = active_children(); writer._patience = 0.1; os.kill(writer.pid, SIGSTOP)"
    _interrupted("LocalFleet.start", stuck, tmp_path)


def _interrupted(moment: str, before: str, tmp_path: Path) -> None:
    """Have Ctrl-C come at a moment of a recorded run, after something else."""
    target = tmp_path / "result.json"
    command = f"""
import os
from multiprocessing import active_children
from signal import SIGINT, SIGSTOP, raise_signal
from deploy import cli
from deploy.run.fault_schedule import FaultSchedule
from deploy.run.local import LocalFleet
def interrupted(*given):
    {before}
    raise_signal(SIGINT)
{moment} = interrupted
cli.main()
"""
    options = f"run swap-2 --transport local --quiet --record {tmp_path}/run.mcap --json {target}".split()
    assert ended(command, *options).returncode == EXIT_INTERRUPTED
    assert json.loads(target.read_text())["verdict"] == "interrupted"


def test_as_the_page_starts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    @contextmanager
    def live_page(*_: object) -> Any:
        ctrl_c()
        yield

    monkeypatch.setattr(execution, "live_page", live_page)
    _, written = _run(tmp_path, web=True)
    assert written["verdict"] == "interrupted"


@pytest.mark.parametrize("place", [(WorldNode, "interrupt"), (Recorder, "close")])
def test_another_at_the_last_words(
    place: tuple[type, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    owner, name = place
    usual = getattr(owner, name)

    def interrupted(node: Any, *arguments: str) -> None:
        ctrl_c()
        usual(node, *arguments)

    interruptions = iter([ctrl_c])

    def watch(_: object) -> None:
        for each in interruptions:
            each()

    monkeypatch.setattr(owner, name, interrupted)
    with LocalFleet([SWAP], watch=watch, record=tmp_path / "run.mcap") as fleet:
        (report,) = fleet.execute()
    assert report["verdict"] == "interrupted"


def test_as_the_fleet_is_taken_down(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = LocalFleet._finish

    def interrupted(fleet: LocalFleet, result: str | None) -> None:
        if result is None:
            ctrl_c()
        usual(fleet, result)

    monkeypatch.setattr(LocalFleet, "_finish", interrupted)
    result, written = _run(tmp_path)
    assert (result["verdict"], written["verdict"]) == ("arrived", "arrived")


def test_as_processes_leave(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who has all reports has what the processes cost, and ends them, too."""
    with Fleet([SWAP], RunOptions("mesh")) as fleet:
        (report,) = fleet.execute()
        poll = fleet._supervisor.poll
        stop = fleet._supervisor.stop
        monkeypatch.setattr(fleet._supervisor, "poll", lambda *given: (ctrl_c(), poll(*given))[1])
        monkeypatch.setattr(fleet._supervisor, "stop", lambda **given: (ctrl_c(), stop(**given))[1])
        rows = fleet.processes()
        fleet._stack.callback(ctrl_c)
    assert report["verdict"] == "arrived"
    assert len(rows) == len(SWAP.robots) + 1
