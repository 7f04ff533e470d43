"""Other floors: the same lock-step messages, nothing computed, over pyzmq and over the system's pipes.

Both are meshes: a state goes straight from its robot to every other, and no router stands between.
Everybody has one inbox, under the name of the folder that they share; the world's is number 0.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, Protocol

from deploy.processes.spawn import Spawner
from deploy.processes.supervisor import Supervisor
from deploy.processes.table import Process
from tests.benchmarks.transport.bare import Payloads, Rate, timed

Carrier = Literal["zmq", "pipes"]
_MODULE = "tests.benchmarks.transport.meshes"
_PATIENCE = 20.0  # s for all inboxes to be there


class Node(Protocol):
    """One participant of either carrier."""

    def send(self, to: int, payload: bytes) -> None:
        """Put `payload` into an inbox."""

    def receive(self) -> bytes:
        """Wait for the next payload in the own one."""


class ZmqNode:
    """A PULL socket as the inbox, a PUSH socket to each of the others."""

    def __init__(self, folder: Path, own: int, robots: int) -> None:
        import zmq

        context = zmq.Context.instance()
        self._inbox = context.socket(zmq.PULL)
        self._inbox.bind(f"ipc://{folder}/{own}")
        self._others = {}
        for other in range(robots + 1):
            if other != own:
                self._others[other] = context.socket(zmq.PUSH)
                self._others[other].connect(f"ipc://{folder}/{other}")

    def send(self, to: int, payload: bytes) -> None:
        self._others[to].send(payload)

    def receive(self) -> bytes:
        return bytes(self._inbox.recv())


class PipeNode:
    """A named pipe as the inbox; small writes are atomic, so that all may write to it."""

    def __init__(self, folder: Path, own: int, robots: int) -> None:
        os.mkfifo(folder / f"new-{own}")
        (folder / f"new-{own}").rename(folder / str(own))
        self._inbox = Channel(os.open(folder / str(own), os.O_RDWR), writable=False)
        deadline = time.monotonic() + _PATIENCE
        while len([path for path in folder.iterdir() if path.name.isdigit()]) <= robots:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{folder}: not all of {robots + 1} inboxes within {_PATIENCE:g} s")
            time.sleep(0.005)
        self._others = {
            other: Channel(os.open(folder / str(other), os.O_RDWR), readable=False)
            for other in range(robots + 1)
        }

    def send(self, to: int, payload: bytes) -> None:
        self._others[to].send_bytes(payload)

    def receive(self) -> bytes:
        return self._inbox.recv_bytes()


_NODES: dict[Carrier, type[ZmqNode] | type[PipeNode]] = {"zmq": ZmqNode, "pipes": PipeNode}


def robot(carrier: Carrier, folder: Path, own: int, robots: int, say: Payloads) -> int:
    """One robot; ends when it is told to."""
    node: Node = _NODES[carrier](folder, own, robots)
    others = [other for other in range(1, robots + 1) if other != own]
    heard, measured = 0, False
    node.send(0, say.command)  # it is there
    while True:
        if node.receive()[0] == say.tick[0]:
            measured = True
            for other in others:
                node.send(other, say.state)
        else:
            heard += 1
        if measured and heard == len(others):
            heard, measured = 0, False
            node.send(0, say.command)


def world(
    carrier: Carrier,
    folder: Path,
    robots: int,
    seconds: float,
    say: Payloads,
    report: Callable[[str], None],
) -> int:
    """The world; reports the rate."""
    node: Node = _NODES[carrier](folder, 0, robots)

    def hear() -> None:
        for _ in range(robots):
            node.receive()

    def tick() -> None:
        for each in range(1, robots + 1):
            node.send(each, say.tick)
        hear()

    hear()
    report(timed(tick, seconds))
    return 0


def rate(robots: int, seconds: float, carrier: Carrier) -> Rate:
    """Lock-step ticks of `robots` processes over another carrier."""
    from tests.benchmarks.transport.payloads import payloads  # here, so that the processes do without a fleet

    say = payloads(robots)
    with (
        TemporaryDirectory(prefix="disknav-") as folder,
        Supervisor(Spawner(("zmq", "deploy.processes.table", _MODULE))) as supervisor,
    ):
        path = Path(folder)
        supervisor.start(
            Process(f"robot-{i}", f"{_MODULE}:robot", (carrier, path, i, robots, say))
            for i in range(1, robots + 1)
        )
        supervisor.start(
            [Process("world", f"{_MODULE}:world", (carrier, path, robots, seconds, say), reports=True)]
        )
        ticks, frequency = map(float, supervisor.report("world", seconds + 30.0).split())
        cpu = sum(usage.cpu_s for usage in supervisor.usage())
    return Rate(frequency, 1000.0 * cpu / ticks)
