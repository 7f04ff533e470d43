"""Titles and short names tell the processes of a fleet apart."""

import sys
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, fresh_run_name
from protocol.messages import Clock

pytestmark = [
    pytest.mark.process,
    pytest.mark.timeout(90),
    pytest.mark.skipif(sys.platform != "linux", reason="reads /proc"),
]


def title(pid: int) -> str:
    """The command line, as `ps -f` shows it."""
    return Path(f"/proc/{pid}/cmdline").read_bytes().rstrip(b"\0").replace(b"\0", b" ").decode()


def short(pid: int) -> str:
    """The short name, as `top` shows it."""
    return Path(f"/proc/{pid}/comm").read_text().removesuffix("\n")


def test_a_fleet_is_told_apart(tmp_path: Path) -> None:
    run = fresh_run_name()
    pair = load("swap-2", ["control.speed=0.01", "time.limit=60"])
    scenario = replace(pair, robots=(pair.robots[0], replace(pair.robots[1], id=12)))
    seen: dict[str, int] = {}
    titles: set[str] = set()

    def look(clock: Clock) -> None:
        if clock.tick < 2 or seen:
            return
        seen.update(fleet.supervisor.pids())
        assert {name: title(pid) for name, pid in seen.items()} == {
            name: f"disknav {name.replace('-', ' ')} (run {run})" for name in seen
        }
        assert short(seen["robot-1"]) == f"robot 1 {run}"[:15]
        assert short(seen["robot-12"]) == f"robot 12 {run}"[:15]
        server = psutil.Process(seen["world"]).parent()
        titles.update(title(each.pid) for each in [server, *server.children(recursive=True)])

    options = RunOptions(mode="realtime", run=run)
    with Fleet(scenario, options, watch=look, record=tmp_path / "run.mcap") as fleet:
        fleet.execute(enough=lambda: bool(seen))
    names = ["fork server", "router", "recorder", "world", *(f"robot {n}" for n in scenario.ids)]
    assert titles == {f"disknav {name} (run {run})" for name in names}
