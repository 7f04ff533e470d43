"""Three hosts, each with a router and two robots, and a cable that is pulled in the middle of a run."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from deploy.load import load
from deploy.security.keystore import create
from deploy.security.roster import Roster
from protocol.scenario_file import write_toml
from tests.hosts.network import Hosts, needs_hosts

pytestmark = [pytest.mark.process, pytest.mark.slow, pytest.mark.timeout(240), needs_hosts]

SCENARIO = load("figure-1", ["control.speed=0.03", "time.limit=90"], 3)
RUN = "apart"
HOMES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 3, 6: 3}  # robot -> host
# What the engines of `disknav deploy` do for a robot that failed.
UNTIL_SUCCESS = [
    "sh",
    "-c",
    """trap 'kill $!; exit' TERM; until { "$@" & wait $!; }; do sleep 0.5; done""",
    "sh",
]
DISKNAV = [sys.executable, "-m", "deploy.cli"]


class Field:
    """A secured fleet over three hosts; the world and the observer are on the first."""

    def __init__(self, hosts: Hosts, folder: Path) -> None:
        self._hosts, self._keys = hosts, folder / "keys"
        create(self._keys, Roster(RUN, SCENARIO.ids), hosts=[hosts.address(host) for host in (1, 2, 3)])
        (folder / "scenario.toml").write_text(write_toml(SCENARIO))
        for host in (1, 2, 3):
            before = [word for other in range(1, host) for word in ("--connect", self._router(other))]
            self._start(host, "router", "--listen", self._router(host), *before, connect=False)
            hosts.await_log(f"listening on {self._router(host)}", 60.0)
        self._start(1, "world", str(folder / "scenario.toml"), "--mode", "realtime")
        observer = [sys.executable, "-m", "tests.hosts.observer", self._router(1), RUN, str(self._keys)]
        self._told = hosts.start(1, observer).stdout
        assert next(self.told()) == {"world": "answers"}
        for robot, host in HOMES.items():
            self._start(host, "robot", str(robot), again=True)

    def told(self) -> Iterator[dict[str, Any]]:
        """What the observer tells, until the result."""
        assert self._told is not None
        for line in self._told:
            yield json.loads(line)

    def _router(self, host: int) -> str:
        return f"tls/{self._hosts.address(host)}:7447"

    def _start(self, host: int, *command: str, connect: bool = True, again: bool = False) -> None:
        connection = ["--router", self._router(host)] if connect else []
        words = [*DISKNAV, *command, *connection, "--secure", str(self._keys)]
        self._hosts.start(host, [*UNTIL_SUCCESS, *words] if again else words)


@pytest.fixture
def field(tmp_path: Path) -> Iterator[tuple[Hosts, Field]]:
    with Hosts(3, tmp_path / "log") as hosts:
        yield hosts, Field(hosts, tmp_path)


def test_a_cable_pulled_for_seconds(field: tuple[Hosts, Field]) -> None:
    hosts, fleet = field
    cut, mended = SCENARIO.ticks(3.0), SCENARIO.ticks(6.5)
    truth: dict[int, dict[str, list[float]]] = {}
    report: dict[str, Any] = {}
    for told in fleet.told():
        if "report" in told:
            report = told["report"]
        else:
            truth[told["tick"]] = told["positions"]
            if told["tick"] == cut:
                hosts.cut(3)
            elif told["tick"] == mended:
                hosts.mend(3)
    silent = cut + SCENARIO.ticks(0.5)  # the world noticed by then that it hears nothing
    during = [positions for tick, positions in truth.items() if silent <= tick <= mended]
    assert len(during) > SCENARIO.ticks(2.0)
    moved = {robot: any(each[robot] != during[0][robot] for each in during) for robot in during[0]}
    assert moved == {"1": True, "2": True, "3": True, "4": True, "5": False, "6": False}
    assert report["verdict"] == "arrived"
    assert report["collisions"] == 0
    assert report["min_clearance"] > 0.0
