"""Events of the participants of a run: tokens that come and go, messages, requests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from random import Random
from unittest.mock import patch

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Event, Presence, Request, Sample
from protocol.bus.local import LocalNetwork
from protocol.errors import MessageError
from protocol.scenario.model import Scenario
from protocol.streams import STREAMS
from tests.deploy.telemetry.monitor.watched import watch_local
from tests.fuzz.mutation import damaged_message, damaged_text
from tests.fuzz.target import Target
from tests.fuzz.targets.joining import requests, steers
from tests.fuzz.traffic import EPOCH, traffic
from world.shell.node import WorldNode

_RUN = "local"  # the name of a run in one process
_EVENTS = (
    f"disknav/{_RUN}/robot/0/alive/5c1f", f"disknav/{_RUN}/robot/x/alive/1",
    f"disknav/{_RUN}/robot/7/alive/1",
    f"disknav/{_RUN}/robot/999999999/alive/1", f"disknav/{_RUN}/robot/1/alive/1",
    f"disknav/{_RUN}/robot/alive",
    f"disknav/{_RUN}/robot/1/2/3/4/5/alive", f"disknav/{_RUN}/robot/*/command", f"disknav/{_RUN}/**", "**",
    f"disknav/{_RUN}/world/scenario", f"disknav/{_RUN}/world/control", f"disknav/{_RUN}/world/alive/1",
    f"disknav/{_RUN}/world/*", "@/router/alive", "", f"disknav/{_RUN}/world/operation",
)  # fmt: skip
_Drawn = tuple[str, str, bytes]  # what happens, under which key, with what


def _draw_events(rng: Random) -> list[_Drawn]:
    return [_draw_event(rng) for _ in range(rng.randint(1, 4))]


def _draw_event(rng: Random) -> _Drawn:
    happens = rng.choice(("appears", "goes", "published", "published", "asked"))
    key = rng.choice(_EVENTS)
    valid, other = rng.choice(requests()), rng.choice(steers())
    if happens == "published":
        samples = traffic()[rng.choice(tuple(STREAMS))]
        (key, valid), (_, other) = rng.choice(samples), rng.choice(samples)
    match rng.randrange(6):
        case 0:
            key = damaged_text(key, rng.choice(_EVENTS), rng)
        case 1:
            key = rng.choice(_EVENTS)
    return happens, key, damaged_message(valid, other, rng)


@cache
def _participants_of() -> Scenario:
    return load("swap-2")


def _deaf(_: bytes) -> None:
    """Hear a reply, and make nothing of it."""


def _take_part(drawn: list[_Drawn]) -> bool:
    """World, robot, watcher and launcher handle them; the world counts those of unknown robots."""
    network = LocalNetwork()
    bus = network.connect()
    with patch("world.shell.node.drawn_epoch", return_value=EPOCH):
        world = bus.node = WorldNode(bus, _RUN, _participants_of())
    robots = network.connect()
    robot = robots.node = RobotNode(robots, _RUN, 1)
    robot.wake(0.0)
    watcher = watch_local(network, _RUN)
    watcher.wake(0.0)
    launcher = Fleet(_participants_of(), RunOptions())
    handlers: list[Callable[[Event], object]] = [
        robot.handle,
        watcher.handle,
        launcher._take,
        world.handle,
    ]
    for happens, key, payload in drawn:
        event: Event
        if happens == "published":
            event = Sample(key, payload)
        elif happens == "asked":
            event = Request(key, payload, _deaf)
        else:
            event = Presence(key, happens == "appears")
        for handle in handlers[-1:] if happens == "asked" else handlers:
            handle(event)
    watcher.snapshot()
    watcher.overview()
    rejected = world._run.rejected
    if rejected.total():
        raise MessageError(next(iter(rejected)), f"counted: {dict(rejected)}")
    return True


PARTICIPANTS = {"event": Target(_draw_events, _take_part, MessageError, 2)}
