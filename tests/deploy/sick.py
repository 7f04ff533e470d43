"""Robots that are not well, each a process of its own."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

from agents.process import main
from deploy import process_table as table
from deploy.fleet import Fleet
from deploy.options import RunOptions
from protocol import joining
from protocol.bus_zenoh import ZenohBus
from protocol.connection import Connection
from protocol.keys import world_key
from protocol.scenario import Scenario


class FleetWithOne(Fleet):
    """A fleet in which robot `sick` is another function of this module.

    Args:
        scenario, options: as of any fleet.
        entry: name of the function; it takes connection, run, robot and `arguments`.
    """

    def __init__(
        self, scenario: Scenario, options: RunOptions, sick: int, entry: str, *arguments: object
    ) -> None:
        super().__init__([scenario], options)
        self._sick, self._entry, self._arguments = table.robot_name(sick), entry, arguments

    def _robots(self) -> list[table.Process]:
        return [self._made_sick(row) if row.name == self._sick else row for row in super()._robots()]

    def _made_sick(self, row: table.Process) -> table.Process:
        entry = f"tests.deploy.sick:{self._entry}"
        return table.Process(row.name, entry, (*row.arguments, *self._arguments), restarts=row.restarts)


def dies_once_admitted(connection: Connection, run: str, robot: int, marker: Path) -> int:
    """End between admission and liveliness token; be well in the next life."""
    if marker.exists():
        return main(connection, run, robot)
    request = joining.encode_request(joining.Join(robot, "first"))
    with closing(ZenohBus(connection)) as bus:
        reply = joining.decode_reply(bus.ask(world_key(run, "scenario"), request, 10.0))
    assert isinstance(reply, joining.Admission)
    marker.touch()
    os._exit(1)
