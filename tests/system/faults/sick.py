"""Robots that are not well, each a process of its own."""

from __future__ import annotations

import os
import time
from contextlib import closing
from pathlib import Path
from typing import Any

from agents.process import main
from agents.shell.node import RobotNode
from deploy.processes import table
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol import joining
from protocol.bus.bus import Event, drive
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.keys import robot_key
from protocol.scenario.model import Scenario


class FleetWithOne(Fleet):
    """A fleet in which robot `sick` is another function of this module.

    Args:
        scenario, options: as of any fleet.
        entry: name of the function; it takes connection, run, robot and `arguments`.
    """

    def __init__(
        self, scenario: Scenario, options: RunOptions, sick: int, entry: str, *arguments: object
    ) -> None:
        super().__init__(scenario, options)
        self._sick, self._entry, self._arguments = table.robot_name(sick), entry, arguments

    def _robots(self) -> list[table.Process]:
        return [self._made_sick(row) if row.name == self._sick else row for row in super()._robots()]

    def _made_sick(self, row: table.Process) -> table.Process:
        entry = f"tests.system.faults.sick:{self._entry}"
        connection, run, robot = row.arguments[:3]  # on whatever core
        arguments = (connection, run, robot, *self._arguments)
        return table.Process(row.name, entry, arguments, restarts=row.restarts)


def dies_once_admitted(connection: Connection, run: str, robot: int, marker: Path) -> int:
    """End between admission and liveliness token; be well in the next life."""
    if marker.exists():
        return main(connection, run, robot)
    request = joining.encode_request(joining.Join(robot, "first"))
    with closing(ZenohBus(connection)) as bus:
        reply = joining.decode_reply(bus.ask(robot_key(run, robot, "join"), request, 10.0)[0])
    assert isinstance(reply, joining.Admission)
    marker.touch()
    os._exit(1)


class _Hanging:
    """A node whose interpreter hangs once a tick has come; its session lives, and its token stays."""

    def __init__(self, node: RobotNode, tick: int) -> None:
        self._node, self._tick = node, tick

    def handle(self, event: Event) -> None:
        while self._node.core is not None and self._node.core.tick >= self._tick:
            time.sleep(60.0)  # as long as it takes
        self._node.handle(event)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)


def hangs(connection: Connection, run: str, robot: int, tick: int) -> int:
    """Handle nothing any more from `tick` on."""
    bus = ZenohBus(connection)
    drive(_Hanging(RobotNode(bus, run, robot), tick), bus)
    return 0
