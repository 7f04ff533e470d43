"""Watching from outside, over zenoh."""

from __future__ import annotations

from contextlib import closing

import pytest

from deploy.processes.router import listening
from deploy.run.options import fresh_run_name
from deploy.telemetry.monitor.watcher import attach
from protocol.bus.bus import Event, Presence, Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import encode
from protocol.errors import BusError
from protocol.joining import Overview, encode_reply
from protocol.keys import robot_token, world_key, world_token
from protocol.messages import Clock, Truth
from protocol.streams import STREAMS
from tests.deploy.telemetry.monitor.watched import ring, until


class World:
    """The least that a watcher needs of a world, on a bus of its own."""

    def __init__(self, endpoint: str, run: str) -> None:
        self.run = run
        self.bus = ZenohBus(Connection(connect=(endpoint,)))
        self.bus.serve(world_key(run, "scenario"))
        self.clock = self.bus.publisher(STREAMS["clock"], world_key(run, "clock"))
        self.truth = self.bus.publisher(STREAMS["truth"], world_key(run, "truth"))
        self.bus.announce(world_token(run, "1"))
        self.tick = 0
        self.asked = False

    def turn(self) -> None:
        """Answer all requests, and let a tick go by."""
        event: Event | None = self.bus.receive(0.02)
        if event is not None and not isinstance(event, Sample | Presence):
            event.reply(encode_reply(Overview(ring(2), True)))
            self.asked = True
        self.clock(encode(Clock(self.tick, 0.05 * self.tick, (1, 2), (), "")))
        self.tick += 1
        self.truth(encode(Truth(self.tick, (1, 2), ((0.001 * self.tick, 0.0), (0.1, 0.1)), 0.01, 0.5)))


@pytest.mark.process
def test_endpoint_and_run_name_are_enough_and_tokens_come_and_go() -> None:
    router, endpoint = listening(Connection("router"))
    run = fresh_run_name()
    with closing(router), closing(attach(Connection(connect=(endpoint,)), run)) as watcher:
        assert watcher.snapshot()["phase"] == "searching"  # the run begins later
        world = World(endpoint, run)
        with closing(world.bus):
            robot = ZenohBus(Connection(connect=(endpoint,)))
            robot.announce(robot_token(run, 2, "1"))
            until(lambda: (world.turn(), watcher.snapshot()["tick"] > 3)[1])
            assert [row["alive"] for row in watcher.snapshot()["robots"]] == [None, True]
            robot.close()
            until(lambda: watcher.snapshot()["robots"][1]["status"] == "dead", 5.0)
        until(lambda: watcher.snapshot()["phase"] == "lost")
        second = World(endpoint, run)  # another world under this name: everything anew
        with closing(second.bus):
            until(lambda: (second.turn(), watcher.overview()["epoch"] == 2)[1])


def test_nobody_at_the_endpoint_is_an_error() -> None:
    with pytest.raises(BusError):
        attach(Connection(connect=("tcp/127.0.0.1:1",), timeout=0.2), "r")
