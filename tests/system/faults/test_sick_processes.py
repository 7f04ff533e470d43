"""A process that hangs costs one robot: real processes on real zenoh."""

import re
import signal
import time
from typing import Any

import pytest

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.processes import table
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Event, drive
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from tests.proxy import Proxy

HANGS = 30  # tick


def hang(connection: Connection, run: str, robot: int) -> int:
    """The process of robot 2: its interpreter hangs once a tick has come; session and token stay."""
    bus = ZenohBus(connection)
    node = RobotNode(bus, run, robot)

    def handle(event: Event) -> None:
        while node.core is not None and node.core.tick >= HANGS:
            time.sleep(60.0)  # as long as it takes
        node.handle(event)

    drive(Proxy(node, handle=handle), bus)
    return 0


@pytest.mark.process
@pytest.mark.timeout(150)
@pytest.mark.long(10)
def test_one_that_hangs_is_given_up_alone(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    row = table.robot

    def sick(connection: Connection, run: str, robot: int, *rest: Any, **options: Any) -> table.Process:
        entry = f"tests.system.faults.test_sick_processes:{hang.__name__}"
        return (
            table.Process(table.robot_role(2), entry, (connection, run, robot))
            if robot == 2
            else row(connection, run, robot, *rest, **options)
        )

    monkeypatch.setattr(table, "robot", sick)
    with Fleet(load("swap-4", ["time.fence=0.3", "time.limit=30.0"]), RunOptions()) as fleet:
        report = fleet.execute()
        fleet.supervisor.signal(table.robot_role(2), signal.SIGKILL)  # which a fleet does after a while
        ends = {row["name"]: row["exit_code"] for row in fleet.processes()}
    assert report["arrived"] == [1, 3, 4], (report["verdict"], report["reason"])
    assert report["collisions"] == 0
    given_up = report["faults"]["given_up"]
    assert {(each["robot"], each["tick"]) for each in given_up} == {(2, HANGS)}
    assert re.search("hangs|lack it", given_up[0]["reason"])
    assert "world: tick 30: gives up robot 2, which " in capfd.readouterr().err
    assert all(ends[f"robot-{robot}"] == 0 for robot in (1, 3, 4))
