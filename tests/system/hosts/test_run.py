"""`disknav run --hosts`: hosts behind an ssh server on the loopback, each with a router port of its own."""

import json
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import psutil
import pytest

from deploy.library.load import load
from deploy.output import EXIT_FAULT, EXIT_OTHERWISE
from deploy.run.local import LocalFleet
from protocol.bus.bus import Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.keys import world_key
from protocol.messages import Clock
from tests.deploy.processes.ports import free_ports
from tests.deploy.processes.test_spawn import gone
from tests.deploy.processes.test_titles import title
from tests.forks import Forks
from tests.system.hosts.testbed.ssh_server import ROOT, Server, needs_sshd, ssh_server
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(90), needs_sshd]

HOSTS = {"base": (1,), "left": (2,), "right": (3,)}
SCENARIO = load("figure-2")
LONG = ["--mode", "realtime", "--set", "control.speed=0.01", "--set", "time.limit=120"]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with ssh_server(tmp_path_factory.mktemp("sshd")) as server:
        yield server


def table(
    server: Server, folder: Path, over_ssh: Sequence[str] = tuple(HOSTS), **changes: str
) -> tuple[Path, int]:
    """A table of three hosts, and the port of its world's router; `changes` are to the second host."""
    text, ports = "", free_ports(3)
    for (name, robots), port in zip(HOSTS.items(), ports, strict=True):
        ssh = f"{server.user}@127.0.0.1" if name in over_ssh else ""
        values = {"name": name, "address": "127.0.0.1", "port": port, "robots": robots, "ssh": ssh}
        values |= {
            "options": server.options,
            "command": server.command,
            **(changes if name == "left" else {}),
        }
        text += "[[hosts]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in values.items())
    path = folder / "hosts.toml"
    path.write_text(text)
    return path, ports[0]


@contextmanager
def a_long_run(
    server: Server, folder: Path, over_ssh: Sequence[str] = ("base", "left"), **changes: str
) -> Iterator[subprocess.Popen[bytes]]:
    """A launcher whose fleet runs; afterwards nothing of that is left on the hosts, or soon will not be."""
    hosts, port = table(server, folder, over_ssh, **changes)
    command = [sys.executable, "-m", "disknav", "run", "figure-2", "--hosts", str(hosts), "--run", "long"]
    command += [*LONG, "--quiet", "--json", str(folder / "result.json")]
    launcher = subprocess.Popen(command, start_new_session=True)
    try:
        await_ticks(port)
        there = [
            *psutil.Process(server.pid).children(recursive=True),
            *psutil.Process(launcher.pid).children(recursive=True),
        ]
        assert len(there) > 8
        names = ["fork server", "router base", "router left", "router right", "world"]
        expected = {f"disknav {name} (run long)" for name in [*names, *(f"robot {n}" for n in SCENARIO.ids)]}
        assert expected <= {title(each.pid) for each in there}
        yield launcher
        until(lambda: all(gone(each.pid) for each in there))
    finally:
        launcher.kill()
        launcher.wait()


def port_of(folder: Path) -> int:
    return int(tomllib.loads((folder / "hosts.toml").read_text())["hosts"][0]["port"])


def await_ticks(port: int, condition: Callable[[Clock], bool] = lambda _: True, more: int = 2) -> None:
    ticks = list[int]()  # that met the condition
    with closing(ZenohBus(Connection(connect=(f"tcp/127.0.0.1:{port}",), timeout=40.0))) as bus:

        def goes_on() -> bool:
            event = bus.receive(1.0)
            if isinstance(event, Sample) and condition(clock := decode(event.key, event.payload)):
                ticks.append(clock.tick)
            return bool(ticks) and ticks[-1] > ticks[0] + more

        bus.subscribe(world_key("long", "clock"))
        until(goes_on, 40.0, "the fleet did not start")


def result(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "result.json").read_text())


def test_the_trajectory_is_that_of_one_host_under_keys(
    server: Server, disknav: Forks, tmp_path: Path
) -> None:
    keys, record = tmp_path / "keys", tmp_path / "run.mcap"
    hosts, _ = table(server, tmp_path)
    made = disknav("setup", "keys", keys, "-s", "figure-2", "--hosts", hosts, "--run", "yard")
    assert made.returncode == 0, made.stderr
    options = ["--secure", keys, "--record", record, "--log", tmp_path / "logs", "--json", "-"]
    done = disknav("run", "figure-2", "--hosts", hosts, *options)
    assert done.returncode == 0, done.stderr
    assert_logged(tmp_path / "logs")
    found = json.loads(done.stdout)
    alone = LocalFleet(SCENARIO).execute()
    assert found["trajectory_sha256"] == alone["trajectory_sha256"]
    where = {row["name"]: row.get("host") for row in found["processes"]}
    assert where.pop("recorder") is None
    assert where == {
        **{f"router-{name}": name for name in HOSTS},
        "world": "base",
        **{f"robot-{robot}": name for name, robots in HOSTS.items() for robot in robots},
    }
    ends = {row["name"]: row["exit_code"] for row in found["processes"]}
    assert ends.pop("recorder") is None, "it waits for this result"
    assert set(ends.values()) == {0}
    assert all(row["cpu_s"] > 0.0 for row in found["processes"] if row["name"] in ends)
    assert psutil.wait_procs(psutil.Process(server.pid).children(recursive=True), timeout=10.0)[1] == []
    assert record.stat().st_size > 0


def assert_logged(folder: Path) -> None:
    """Every host has a file here in which each of its processes began and ended."""
    files = {path.stem: path.read_text().splitlines() for path in folder.iterdir()}
    assert files.keys() == {"launcher", "recorder", *HOSTS}
    for host, robots in HOSTS.items():
        lines = [json.loads(line) for line in files[host]]
        assert all((line["run"], line["host"]) == ("yard", host) for line in lines)
        ended = {line["robot"] for line in lines if line["text"] == "ends with status 0"}
        assert ended == {None, *robots}


def test_a_launcher_that_is_killed_leaves_nothing(server: Server, tmp_path: Path) -> None:
    with a_long_run(server, tmp_path) as launcher:
        launcher.kill()


def lose(launcher: subprocess.Popen[bytes], host: int) -> None:
    """Kill the connection to one of the hosts that are reached by ssh, in the order of the table."""
    connections = [each for each in psutil.Process(launcher.pid).children() if each.name() == "ssh"]
    sorted(connections, key=lambda each: each.create_time())[host].kill()


@pytest.mark.long(10)
def test_a_host_that_is_lost_or_lies_costs_its_own_robots_only(server: Server, tmp_path: Path) -> None:
    python = f"env PYTHONPATH={ROOT} {sys.executable}"
    liar = f"{python} -m tests.system.hosts.testbed.liar {server.command}"
    with a_long_run(server, tmp_path, over_ssh=tuple(HOSTS), command=liar) as launcher:
        lose(launcher, 2)
        await_ticks(port_of(tmp_path), lambda clock: 3 not in clock.active)
        (left,) = (
            each
            for each in psutil.Process(server.pid).children(recursive=True)
            if "tests.system.hosts.testbed.liar" in each.cmdline()
        )
        left.send_signal(signal.SIGUSR1)
        await_ticks(port_of(tmp_path), lambda clock: 2 not in clock.active, more=20)
        launcher.send_signal(signal.SIGTERM)
        assert launcher.wait(20.0) == 128 + signal.SIGTERM
    found = result(tmp_path)
    assert found["down"] == [2, 3]
    assert found["min_clearance"] > 0.0
    ends = {row["name"]: row["exit_code"] for row in found["processes"]}
    lost = {"router-left", "robot-2", "router-right", "robot-3"}
    assert {name for name, code in ends.items() if code == EXIT_FAULT} == lost


def test_the_host_of_the_world_ends_the_run(server: Server, tmp_path: Path) -> None:
    with a_long_run(server, tmp_path) as launcher:
        lose(launcher, 0)
        assert launcher.wait(20.0) == EXIT_OTHERWISE
    found = result(tmp_path)
    assert found["verdict"] == "aborted"
    assert "host base is gone: ssh ended by signal 9" in found["reason"]


def test_a_host_that_cannot_be_used_is_named(server: Server, disknav: Forks, tmp_path: Path) -> None:
    hosts, _ = table(server, tmp_path, ["left"], command="/nowhere/it")
    done = disknav("run", "figure-2", "--hosts", hosts)
    assert done.returncode == EXIT_FAULT
    assert "host left: its shell finds no command '/nowhere/it'" in done.stderr
