"""Whether a process of a run is well: what an orchestrator's probe asks."""

from __future__ import annotations

import time
from contextlib import closing

from deploy.security.roster import ROUTER, WORLD
from protocol.bus.bus import Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.errors import BusError, UsageError
from protocol.keys import robot_key, world_key


def probed_key(run: str, role: str) -> str:
    """The key under which a role is heard as long as it is well: a robot's health, the world's clock.

    Raises:
        UsageError: nothing is heard from that role by itself.
    """
    if role == WORLD:
        return world_key(run, "clock")
    robot = role.removeprefix("robot-")
    if role == ROUTER or not (robot.isascii() and robot.isdecimal()):
        raise UsageError(f"{role!r} cannot be probed: name the world or a robot, such as robot-3")
    return robot_key(run, int(robot), "health")


def probe(connection: Connection, run: str, role: str, within: float) -> None:
    """Return once something is heard of `role`.

    Raises:
        BusError: nothing was, for `within` s, or the router cannot be reached.
    """
    key = probed_key(run, role)
    with closing(ZenohBus(connection)) as bus:
        bus.subscribe(key)
        deadline = time.monotonic() + within
        while (remaining := deadline - time.monotonic()) > 0.0:
            event = bus.receive(remaining)
            if isinstance(event, Sample):
                decode(event.key, event.payload)
                return
    raise BusError(f"nothing received from {role} under {key} for {within:g} s")
