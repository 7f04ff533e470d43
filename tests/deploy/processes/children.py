"""Functions that tests run in processes of their own."""

import os
import signal
from collections.abc import Callable
from contextlib import closing
from multiprocessing.connection import Connection as Channel
from typing import NoReturn

from deploy.processes.spawn import Process, Spawner
from deploy.processes.supervisor import Supervisor
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError
from protocol.process.signals import STOP


def row(name: str, function: Callable[..., object], *arguments: object, **options: object) -> Process:
    """A row of the process table that runs a function of this module."""
    return Process(name, f"tests.deploy.processes.children:{function.__name__}", arguments, **options)  # type: ignore[arg-type]


def spawner() -> Spawner:
    return Spawner(
        ("numpy", "protocol.bus.zenoh", "deploy.processes.router", "tests.deploy.processes.children")
    )


def announce(connection: Connection, key: str) -> int:
    with closing(ZenohBus(connection)) as bus:
        bus.announce(key)
        STOP.wait()
    return 0


def wait(report: Callable[[str], None] | None = None) -> int:
    if report is not None:
        report("waiting")
    STOP.wait()
    return 0


def wait_stubbornly(report: Callable[[str], None]) -> NoReturn:
    """Do nothing, SIGTERM or not."""
    report("waiting")
    while True:
        signal.pause()


def give(code: int) -> int:
    return code


def divide_by_zero() -> float:
    return 1 / 0


def fail_politely() -> int:
    raise BusError("the cable is unplugged")


def print_and_report(report: Callable[[str], None]) -> int:
    print("printed")
    report("reported")
    return 0


def die_while_reporting(report: Callable[[str], None]) -> NoReturn:
    """Be killed in the middle of a report that no pipe holds at once."""
    channel: Channel[str, str] = report.__self__  # type: ignore[attr-defined]  # a method, of that
    os.write(channel.fileno(), (1 << 20).to_bytes(4, "big") + b"half of")
    signal.raise_signal(signal.SIGKILL)
    wait()


def supervise(path: str, names: list[str]) -> None:
    """Be a supervisor whose processes wait; write their pids to `path` when all run, then hang."""
    with Supervisor(spawner()) as supervisor:
        supervisor.start(row(name, wait, reports=True) for name in names)
        for name in names:
            supervisor.report(name, 20.0)
        pids = " ".join(str(usage.pid) for usage in supervisor.usage())
        with open(path + ".new", "w") as file:  # noqa: PTH123
            file.write(pids)
        os.rename(path + ".new", path)  # noqa: PTH104
        signal.pause()
