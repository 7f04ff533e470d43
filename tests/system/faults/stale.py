"""Fleets with processes that live on although their robots' lives are over: how it comes to that, and what
the world answers them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from agents.shell.node import RobotNode
from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Query
from protocol.bus.local import LocalBus
from protocol.joining import Join, Reply, decode_reply, encode_request
from protocol.keys import robot_key
from protocol.scenario.model import ProcessFault, RobotSpec, Scenario
from tests.system.orders.guests import SWAP
from world.coordinator.lives import Life
from world.shell.checkpoint import Checkpoint

ENDLESS = replace(SWAP, time=replace(SWAP.time, endless=True))
RESTARTED = replace(SWAP, process=(ProcessFault(2, 0.5, "restart"),))
AGAIN = RobotSpec(2, 0.02, (0.0, -0.2), (0.1, -0.2))


class Overheard:
    """The world's node; once `when` holds after an event, `then` is done."""

    def __init__(self, fleet: LocalFleet) -> None:
        self._fleet = fleet
        self.when: Callable[[], bool] = lambda: False
        self.then: Callable[[], None] = lambda: None
        fleet.world_bus.node = self

    @property
    def finished(self) -> bool:
        return self._fleet.world.finished

    @property
    def deadline(self) -> float:
        return self._fleet.world.deadline

    def wake(self, now: float) -> None:
        self._fleet.world.wake(now)

    def handle(self, event: Event) -> None:
        self._fleet.world.handle(event)
        if self.when():
            self.when = lambda: False
            self.then()


def kept(folder: Path, scenario: Scenario = RESTARTED) -> LocalFleet:
    """A fleet whose world keeps a checkpoint."""
    Checkpoint.create(folder / "checkpoint")
    return LocalFleet(scenario, checkpoint=folder / "checkpoint")


def deafen_launcher(fleet: LocalFleet) -> None:
    """The launcher of a fleet hears nothing any more."""
    fleet.launcher.follow = lambda _: None  # type: ignore[method-assign]


def go(fleet: LocalFleet, ticks: int, seconds: float = 5.0) -> None:
    """On for some ticks, or not that far in this time."""
    tick, deadline = fleet.world.world.tick + ticks, time.monotonic() + seconds
    fleet.network.run(lambda: fleet.world.world.tick >= tick or time.monotonic() > deadline)


def life(fleet: LocalFleet, robot: int = 2) -> Life:
    return fleet.world.world.coordinator.lives.of[robot]


def status(fleet: LocalFleet, robot: int = 2) -> str:
    return fleet.world.world.coordinator.lives.roster.status(robot)


def answer(fleet: LocalFleet, session: str, robot: int = 2) -> Reply:
    """What the world answers to a process that asks to join."""
    replies: list[bytes] = []
    payload = encode_request(Join(robot, session))
    fleet.world.handle(Query(robot_key(fleet.run, robot, "join"), payload, replies.append))
    return decode_reply(replies[0])


def deafened(fleet: LocalFleet, then: Callable[[], object]) -> tuple[LocalBus, RobotNode]:
    """Robot 2's process, which hears nothing any more from the moment on in which it has commanded."""
    world, ears, bus = fleet.world.world, Overheard(fleet), fleet.robots[2]
    node = bus.node
    assert isinstance(node, RobotNode)

    def deafen() -> None:
        bus.node = None
        then()

    ears.when = lambda: world.is_open and 2 in world.coordinator.commands.taken
    ears.then = deafen
    deadline = time.monotonic() + 5.0
    fleet.network.run(lambda: bus.node is None or time.monotonic() > deadline)
    return bus, node
