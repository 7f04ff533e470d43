"""Orders while a fleet runs on real zenoh: by the Python interface, by any client, from the command line."""

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from deploy.run.operator import operating
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError
from protocol.scenario.model import Journey, Operation, Position
from tests.deploy.processes.ports import free_ports
from tests.forks import Forks
from tests.until import until

PLACE = (0.05, 0.02)


def sent(robot: int, *points: Position, within: float | None = None) -> Operation:
    return Operation(goal=Journey(robot, points, within=within))


@contextmanager
def served(endpoint: str, result: Path) -> Iterator[subprocess.Popen[bytes]]:
    options = ["--run", "yard", "--listen", endpoint, "--json", str(result), "--quiet"]
    options += ["--set", "control.speed=0.3", "--set", "obstacles=[{center=[0.2, 0.2], radius=0.02}]"]
    with subprocess.Popen([sys.executable, "-m", "disknav", "run", "swap-4", "--keep", *options]) as fleet:
        try:
            yield fleet
        finally:
            fleet.terminate()


OBSTACLES = (  # a command, its status, and what it says
    ("place yard -0.19 -0.19 --radius 0.02", 0, "obstacle 2 is in place"),
    ("place yard 0.0 0.0 0.1 0.1 0.1 0.0 0.0 0.1", 2, "sides cross"),
    ("take yard 1", 0, "obstacle 1 is gone"),
    ("take yard 1", 1, "no obstacle 1"),
    ("things yard --json", 0, '"number": 2'),
)


@pytest.mark.process
@pytest.mark.timeout(120)
def test_keep_and_send(disknav: Forks, tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_ports(1)[0]}"
    with served(endpoint, tmp_path / "result.json") as fleet:
        until(lambda: reachable(endpoint), 30.0)
        with operating("yard", endpoint) as operator:
            operator.wait_for_begin(30.0)
            reply = operator.operate(sent(1, PLACE, (0.1, 0.1)))
            assert operator.outcome(1, reply.number, 60.0).status == "arrived"
            assert operator.operate(Operation(halt=True)).halted
            stopped = operator.operate(sent(1, PLACE, within=1.0))
            assert operator.outcome(1, stopped.number, 60.0).status == "given up"  # it could not move
            assert not operator.operate(Operation(halt=False)).halted
            assert "out of the workspace" in operator.operate(sent(1, (9.0, 0.0))).text
            assert "no robot 7" in operator.operate(sent(7, PLACE)).text
        bus = ZenohBus(Connection(connect=(endpoint,)))  # as any client of zenoh
        request = b'{"goal": {"robot": 3, "points": [[0, -0.1]]}}'
        told = json.loads(bus.ask("disknav/yard/world/operation", request, 5.0)[0])
        bus.close()
        assert (told["accepted"], told["number"]) == (True, 3)
        said = disknav("fleet", "goal", "yard", "3", "-0.1", "-0.1", "--router", endpoint, "--json")
        assert json.loads(said.stdout)["status"]["goal"] == [-0.1, -0.1]
        for words, status, text in OBSTACLES:
            done = disknav("fleet", *words.split(), "--router", endpoint)
            assert (done.returncode, text in done.stdout + done.stderr) == (status, True), done
        assert '"number": 1' not in done.stdout
        assert disknav("stop", "yard", "--router", endpoint).returncode == 0
        ordered = disknav("fleet", "goal", "yard", "3", "0", "0", "--router", endpoint)
        assert (ordered.returncode, "emergency stop is in force" in ordered.stderr) == (0, True)
        fleet.send_signal(signal.SIGINT)
        assert fleet.wait(30) == 130
    result = json.loads((tmp_path / "result.json").read_text())
    assert (result["verdict"], result["collisions"]) == ("interrupted", 0)


def reachable(endpoint: str) -> bool:
    try:
        ZenohBus(Connection(connect=(endpoint,), timeout=1.0)).close()
    except BusError:
        return False
    return True
