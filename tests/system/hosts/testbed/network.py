"""Hosts on one machine: a network namespace each, wired to a switch by links that can be cut."""

import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Self

import pytest

from deploy.processes import table
from deploy.run.options import fresh_run_name
from protocol.bus.connection import Connection
from protocol.scenario.model import Scenario

_PORT = 7447
_START = 60.0  # s
_EACH = 5.0  # s, for each robot, whose hosts start one after another while the world waits
_INSIDE = (sys.executable, "-m", "tests.system.hosts.testbed.inside")


def unable() -> str | None:
    """Why hosts cannot be made here; None if they can."""
    if shutil.which("ip") is None:
        return "iproute2 (the command ip) is not installed"
    if os.geteuid() != 0:
        return "network namespaces need root"
    probe = f"disknav-probe-{os.getpid()}"
    done = subprocess.run(["ip", "netns", "add", probe], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        return f"no network namespaces here: {done.stderr.strip()}"
    subprocess.run(["ip", "netns", "del", probe], check=True)
    return None


needs_hosts = pytest.mark.skipif(unable() is not None, reason=unable() or "")


class Hosts:
    """A context manager: `count` hosts, 10.77.0.1 and so on. Leaving it ends all that runs on them."""

    def __init__(self, count: int, log: Path) -> None:
        self._numbers = range(1, count + 1)
        self._prefix = f"disknav-{os.getpid()}"
        self._log = log
        self._processes: list[subprocess.Popen[str]] = []
        self._files: list[IO[str]] = []

    def __enter__(self) -> Self:
        try:
            self._wire()
        except BaseException:
            self._remove()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for process in self._processes:
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        for file in self._files:
            file.close()
        self._remove()

    def address(self, host: int) -> str:
        return f"10.77.0.{host}"

    def start(self, host: int, command: Sequence[str]) -> subprocess.Popen[str]:
        file = self._log.open("a")
        self._files.append(file)
        process = subprocess.Popen(
            ["ip", "netns", "exec", self._name(host), *command],
            stdout=subprocess.PIPE,
            stderr=file,
            text=True,
        )
        self._processes.append(process)
        return process

    def fleet(
        self, scenario: Scenario, homes: Mapping[int, int], *, lockstep: bool
    ) -> Iterator[dict[str, Any]]:
        """Start a fleet with a router on each host; what an observer tells of it, until the result.

        Args:
            scenario: what is run; its world is on the first host, as the observer is.
            homes: the host of each robot.
            lockstep: whether the world waits for its robots.
        """
        run, told = fresh_run_name(), None
        for host in self._numbers:
            own, before = (self._router(host),), tuple(map(self._router, range(1, host)))
            here = Connection(connect=own, timeout=_START)
            rows = [table.router(Connection("router", before, own), host=str(host))]
            rows += [table.world(here, run, scenario, lockstep, _START + _EACH * len(homes))] * (host == 1)
            rows += [table.robot(here, run, robot) for robot in scenario.ids if homes[robot] == host]
            path = self._log.with_suffix(f".{host}")
            path.write_bytes(pickle.dumps(rows))
            starter = self.start(host, [*_INSIDE, "start", str(path)])
            if host == 1:
                told = self.start(1, [*_INSIDE, "observe", self._router(1), run]).stdout
            assert starter.stdout.readline() == "ready\n", self._log.read_text()
        return map(json.loads, told)

    def _router(self, host: int) -> str:
        return f"tcp/{self.address(host)}:{_PORT}"

    def cut(self, host: int) -> None:
        """Unplug a host from the switch: what is sent is lost, and no sender is told."""
        _ip("-n", self._name(0), "link", "set", f"port{host}", "down")

    def mend(self, host: int) -> None:
        """Plug it in again."""
        _ip("-n", self._name(0), "link", "set", f"port{host}", "up")

    def sent(self) -> dict[int, int]:
        """Bytes that each host has sent to others so far, by host; all headers included."""
        told = _ip("-n", self._name(0), "-s", "-j", "link", "show")
        ports = {port["ifname"]: port["stats64"]["rx"]["bytes"] for port in json.loads(told)}
        return {host: ports[f"port{host}"] for host in self._numbers}

    def _name(self, host: int) -> str:
        return f"{self._prefix}-{host}"

    def _wire(self) -> None:
        switch = self._name(0)
        _ip("netns", "add", switch)
        _ip("-n", switch, "link", "add", "switch", "type", "bridge")
        _ip("-n", switch, "link", "set", "switch", "up")
        for host in self._numbers:
            name = self._name(host)
            _ip("netns", "add", name)
            _ip("-n", name, "link", "set", "lo", "up")
            peer = ["peer", "name", f"port{host}", "netns", switch]
            _ip("-n", name, "link", "add", "eth0", "type", "veth", *peer)
            _ip("-n", switch, "link", "set", f"port{host}", "master", "switch", "up")
            _ip("-n", name, "addr", "add", f"{self.address(host)}/24", "dev", "eth0")
            _ip("-n", name, "link", "set", "eth0", "up")

    def _remove(self) -> None:
        for host in (0, *self._numbers):
            left = ["ip", "netns", "pids", self._name(host)]  # whatever its parent did not take along
            for pid in subprocess.run(left, capture_output=True, text=True, check=False).stdout.split():
                with suppress(ProcessLookupError):
                    os.kill(int(pid), signal.SIGKILL)
            subprocess.run(["ip", "netns", "del", self._name(host)], capture_output=True, check=False)


def _ip(*arguments: str) -> str:
    return subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True).stdout
