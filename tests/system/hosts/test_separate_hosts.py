"""Three hosts, each with a router and two robots: a cable that is pulled for seconds."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from deploy.library.load import load
from deploy.security.keystore import create
from deploy.security.roster import Home, KeyRoster
from protocol.scenario.file import write_toml
from protocol.scenario.model import Scenario
from tests.system.hosts.testbed.network import Hosts, needs_hosts

pytestmark = [pytest.mark.process, pytest.mark.slow, pytest.mark.timeout(240), needs_hosts]

SCENARIO = load("figure-1", ["control.speed=0.03", "time.limit=90"], 3)
RUN = "apart"
HOMES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 3, 6: 3}  # robot -> host
DISKNAV = [sys.executable, "-m", "disknav"]


class Field:
    """A secured fleet over three hosts; the world and the observer are on the first."""

    def __init__(self, hosts: Hosts, folder: Path, scenario: Scenario) -> None:
        self._hosts, self._keys = hosts, folder / "keys"
        homes = {
            f"host-{host}": Home(
                (hosts.address(host),), tuple(r for r, home in HOMES.items() if home == host)
            )
            for host in (1, 2, 3)
        }
        create(self._keys, KeyRoster(RUN, scenario.ids, homes, "host-1"))
        (folder / "scenario.toml").write_text(write_toml(scenario))
        for host in (1, 2, 3):
            before = [word for other in range(1, host) for word in ("--connect", self._router(other))]
            self._start(
                host,
                "node",
                "router",
                "--listen",
                self._router(host),
                *before,
                "--host",
                f"host-{host}",
                connect=False,
            )
        for host in (1, 2, 3):
            hosts.await_log(f"listening on {self._router(host)}", 60.0)
        self._start(1, "node", "world", str(folder / "scenario.toml"), "--mode", "realtime")
        observer = [
            sys.executable,
            "-m",
            "tests.system.hosts.testbed.observer",
            self._router(1),
            RUN,
            str(self._keys),
        ]
        self._told = hosts.start(1, observer).stdout
        for robot, host in HOMES.items():
            self._start(host, "node", "robot", str(robot))
        assert next(self.told()) == {"world": "answers"}

    def told(self) -> Iterator[dict[str, Any]]:
        """What the observer tells, until the result."""
        assert self._told is not None
        for line in self._told:
            yield json.loads(line)

    def _router(self, host: int) -> str:
        return f"tls/{self._hosts.address(host)}:7447"

    def _start(self, host: int, *command: str, connect: bool = True) -> None:
        connection = ["--router", self._router(host)] if connect else []
        self._hosts.start(host, [*DISKNAV, *command, *connection, "--secure", str(self._keys)])


@pytest.mark.campaign
def test_a_cable_pulled_for_seconds(tmp_path: Path) -> None:
    with Hosts(3, tmp_path / "log") as hosts:
        _pull(hosts, Field(hosts, tmp_path, SCENARIO))


def _pull(hosts: Hosts, fleet: Field) -> None:
    cut, mended = SCENARIO.ticks(3.0), SCENARIO.ticks(6.5)
    truth: dict[int, dict[str, list[float]]] = {}
    report: dict[str, Any] = {}
    silent = back = None
    for told in fleet.told():
        if "report" in told:
            report = told["report"]
        else:
            truth[told["tick"]] = told["positions"]
            if told["tick"] >= cut and silent is None:  # a watcher may miss a tick
                hosts.cut(3)
                silent = told["tick"] + SCENARIO.ticks(1.0)  # by then the world hears nothing
            elif told["tick"] >= mended and back is None:
                hosts.mend(3)
                back = told["tick"]
    assert silent is not None
    assert back is not None
    during = [positions for tick, positions in truth.items() if silent <= tick <= back]
    assert len(during) > SCENARIO.ticks(1.5)
    moved = {robot: any(each[robot] != during[0][robot] for each in during) for robot in during[0]}
    assert moved == {"1": True, "2": True, "3": True, "4": True, "5": False, "6": False}
    assert report["verdict"] == "arrived"
    assert report["collisions"] == 0
    assert report["min_clearance"] > 0.0
