"""What is fuzzed: everything that reads what strangers wrote, with valid inputs to begin from.

Beyond raising nothing undeclared, what a reader accepts must survive being written and read again.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from random import Random
from typing import Any

import msgspec

from agents.peers.reader import PeerReader
from agents.peers.state import PeerState
from agents.shell.node import RobotNode
from deploy.library.demonstrations import crash
from deploy.library.load import load, read
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.studies.faults.scenario import fault_scenario
from protocol import keys
from protocol.bus.events import Event, Presence, Request, Sample
from protocol.bus.local import LocalNetwork
from protocol.errors import KeyGrammarError, MessageError, ScenarioError
from protocol.keys import ROBOT_STREAMS, WORLD_STREAMS, everything, robot_key
from protocol.messages import Health, State
from protocol.requests import joining
from protocol.requests.steering import Steer, decode_steer
from protocol.scenario.file import (
    apply_settings,
    document_of,
    parse_document,
    parse_toml,
    read_scenario,
    write_toml,
)
from protocol.scenario.model import Network, Scenario
from protocol.streams import STREAMS
from protocol.wire.codec import REASONS, decode, encode
from tests.deploy.telemetry.monitor.watched import watch_local
from tests.fuzz.hosts import HOSTS
from tests.fuzz.kept import KEPT, folder
from tests.fuzz.mutation import WRITTEN, damaged_bytes, damaged_message, damaged_text, damaged_tree, deep
from tests.fuzz.orders import ORDERS
from tests.fuzz.target import Target
from tests.protocol.sample_messages import ONE
from world.shell.node import WorldNode

_KEPT = 40  # valid messages a stream
_SETTINGS = (
    "control.k=80", "robots[1].goal=[0.0, 0.0]", "link.delay=[0.0, 0.3]", "robots[6].id=9",
    "sensing.delay=0.1", "name=x", "process=[]", "time.step=0.05", "sensing[0].bias=[0, 0]",
)  # fmt: skip


# -- messages


@cache
def _traffic() -> dict[str, list[tuple[str, bytes]]]:
    """Keys and payloads of real runs with faults, by stream."""
    heard: defaultdict[str, list[tuple[str, bytes]]] = defaultdict(list)

    class Ear:
        finished, deadline = False, float("inf")

        def handle(self, event: Event) -> None:
            if isinstance(event, Sample):
                heard[event.key.rpartition("/")[2]].append((event.key, event.payload))

        def wake(self, now: float) -> None:
            """Nothing is due."""

    for scenario in (fault_scenario(1), crash(0), replace(crash(0), network=Network("near"))):
        fleet = LocalFleet([scenario], speed=0.0)
        bus = fleet.network.connect()
        bus.subscribe(everything(fleet.run))
        bus.node = Ear()
        fleet.execute()
    heard["goalstatus"].append(
        (robot_key(fleet.run, 1, "goalstatus"), encode(ONE["goalstatus"]))
    )  # none is sent
    assert heard.keys() == STREAMS.keys()
    return {name: sorted(all_)[:: max(1, len(all_) // _KEPT)] for name, all_ in sorted(heard.items())}


def _draw_message(rng: Random) -> tuple[str, bytes]:
    samples = _traffic()[rng.choice(tuple(STREAMS))]
    (key, valid), (_, other) = rng.choice(samples), rng.choice(samples)
    if rng.randrange(8) == 0:
        key = _draw_key(rng)
    return key, damaged_message(valid, other, rng)


def _read_message(drawn: tuple[str, bytes]) -> bool:
    key, payload = drawn
    heard = _heard(key, payload)
    try:
        message = decode(key, payload)
    except MessageError as error:
        assert error.reason in REASONS, error.reason
        assert str(error)
        raise
    assert decode(key, encode(message)) == message
    if isinstance(message, State):
        assert heard is not None
        assert (heard.tick, heard.position, heard.desired) == (
            message.tick,
            message.position,
            message.desired,
        )
    return True


def _heard(key: str, payload: bytes) -> PeerState | None:
    """What the robot after the speaker of a State makes of it; None if it refuses."""
    try:
        address = keys.parse(key)
    except KeyGrammarError:
        return None
    if address.stream != "state" or address.robot is None:
        return None
    try:
        return PeerReader(address.robot + 1, address.robot).read(payload)
    except MessageError as error:
        assert error.reason in REASONS, error.reason
        return None


# -- requests


@cache
def _requests() -> list[bytes]:
    health = decode(*_traffic()["health"][-1])
    assert isinstance(health, Health)
    return [
        joining.encode_request(joining.Join(1, "5f3a", health)),
        joining.encode_request(joining.Join(999, "")),
    ]


@cache
def _replies() -> list[bytes]:
    replies = (
        joining.Admission(3, True, fault_scenario(2), {1: 1, 2: 3}),
        joining.Refusal("robot 9 is not in this run"),
        joining.Wait(0.2, "another process is joining"),
        joining.Finished("arrived"),
        joining.Overview(crash(0), False),
    )
    return list(map(joining.encode_reply, replies))


@cache
def _steers() -> list[bytes]:
    return [msgspec.msgpack.encode(s) for s in (Steer(True, 3, 0.5), {"pause": False}, {"speed": 2}, {})]


def _requested(valid: Callable[[], list[bytes]]) -> Callable[[Random], bytes]:
    return lambda rng: damaged_message(rng.choice(valid()), rng.choice(valid()), rng)


def _read_request(payload: bytes) -> bool:
    join = joining.decode_request(1, payload)
    assert joining.decode_request(1, joining.encode_request(join)) == join
    return True


def _read_reply(payload: bytes) -> bool:
    joining.encode_reply(joining.decode_reply(payload))
    return True


def _read_steer(payload: bytes) -> bool:
    msgspec.msgpack.encode(decode_steer(payload))
    return True


# -- whatever happens to those who take part

_RUN = "local"  # the name of a run in one process
_EVENTS = (
    f"disknav/{_RUN}/robot/0/alive", f"disknav/{_RUN}/robot/x/alive", f"disknav/{_RUN}/robot/7/alive",
    f"disknav/{_RUN}/robot/999999999/alive", f"disknav/{_RUN}/robot/1/alive", f"disknav/{_RUN}/robot/alive",
    f"disknav/{_RUN}/robot/1/2/3/4/5/alive", f"disknav/{_RUN}/robot/*/command", f"disknav/{_RUN}/**", "**",
    f"disknav/{_RUN}/world/scenario", f"disknav/{_RUN}/world/control", f"disknav/{_RUN}/world/alive",
    f"disknav/{_RUN}/world/*", "@/router/alive", "", f"disknav/{_RUN}/robot/1/goal",
    f"disknav/{_RUN}/world/halt", f"disknav/{_RUN}/world/fleet", f"disknav/{_RUN}/world/things",
)  # fmt: skip
_Drawn = tuple[str, str, bytes]  # what happens, under which key, with what


def _draw_events(rng: Random) -> list[_Drawn]:
    return [_draw_event(rng) for _ in range(rng.randint(1, 4))]


def _draw_event(rng: Random) -> _Drawn:
    happens = rng.choice(("appears", "goes", "published", "published", "asked"))
    key = rng.choice(_EVENTS)
    valid, other = rng.choice(_requests()), rng.choice(_steers())
    if happens == "published":
        samples = _traffic()[rng.choice(tuple(STREAMS))]
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
    """A world, a robot, a watcher and a launcher live through it, and the world counts what is nobody's."""
    network = LocalNetwork()
    bus = network.connect()
    world = bus.node = WorldNode(bus, _RUN, [_participants_of()])
    robots = network.connect()
    robot = robots.node = RobotNode(robots, _RUN, 1)
    robot.wake(0.0)
    watcher = watch_local(network, _RUN)
    watcher.wake(0.0)
    launcher = Fleet([_participants_of()], RunOptions())
    everybody: list[Callable[[Event], object]] = [robot.handle, watcher.handle, launcher._take, world.handle]
    for happens, key, payload in drawn:
        event: Event
        if happens == "published":
            event = Sample(key, payload)
        elif happens == "asked":
            event = Request(key, payload, _deaf)
        else:
            event = Presence(key, happens == "appears")
        for handle in everybody[-1:] if happens == "asked" else everybody:
            handle(event)
    watcher.snapshot()
    watcher.overview()
    rejected = world._run.rejected
    if rejected.total():
        raise MessageError(next(iter(rejected)), f"counted: {dict(rejected)}")
    return True


# -- keys


def _draw_key(rng: Random) -> str:
    run = rng.choice(("demo", "a_b-9", "0", "x" * 60))
    robot = rng.choice((1, 7, 64, 999_999_999))
    valid = rng.choice(
        (f"disknav/{run}/robot/{robot}/{rng.choice(ROBOT_STREAMS)}",
         f"disknav/{run}/world/{rng.choice(WORLD_STREAMS)}")
    )  # fmt: skip
    return damaged_text(valid, f"disknav/{run}/world/alive", rng) if rng.randrange(6) else valid


def _read_key(text: str) -> bool:
    run, robot, stream = keys.parse.__wrapped__(text)  # uncached: a cache of a million keys proves nothing
    keys.checked_run(run)
    again = keys.world_key(run, stream) if robot is None else keys.robot_key(run, robot, stream)
    assert again == text
    return True


# -- scenarios


@cache
def _scenarios() -> list[Scenario]:
    named = ("figure-1", "figure-3d", "delay-6", "crash", "swap-4", "random-3")
    return [*map(read, named), *map(fault_scenario, range(8))]


@cache
def _documents() -> list[Any]:
    return [document_of(scenario) for scenario in _scenarios()]


@cache
def _texts() -> list[str]:
    return [write_toml(scenario) for scenario in _scenarios()]


def _draw_document(rng: Random) -> dict[str, Any]:
    tree = damaged_tree(rng.choice(_documents()), rng, WRITTEN)
    return tree if isinstance(tree, dict) else {"robots": tree}


def _draw_text(rng: Random) -> str:
    if rng.randrange(200) == 0:
        opening = rng.choice(("x = " + "[" * 2, "[x.", "x.", "x = {a = ", "[[a]]\n"))
        return str(deep(rng, lambda depth: opening + opening[-3:] * min(depth, 2_000)))
    return damaged_text(rng.choice(_texts()), rng.choice(_texts()), rng)


def _draw_settings(rng: Random) -> list[str]:
    return [_draw_setting(rng) for _ in range(rng.randint(1, 3))]


def _draw_setting(rng: Random) -> str:
    valid = rng.choice(_SETTINGS)
    return damaged_text(valid, rng.choice(_SETTINGS), rng) if rng.randrange(4) else valid


def _draw_file(rng: Random) -> bytes:
    texts = [text.encode() for text in (rng.choice(_texts()), rng.choice(_texts()))]
    return (b"\xef\xbb\xbf" if rng.randrange(4) == 0 else b"") + damaged_bytes(texts[0], texts[1], rng)


def _same_again(scenario: Scenario) -> bool:
    text = write_toml(scenario)
    assert write_toml(parse_toml(text)) == text
    return True


def _read_settings(settings: list[str]) -> bool:
    return _same_again(parse_document(apply_settings(_documents()[0], settings)))


def _read_file(content: bytes) -> bool:
    path = folder() / "scenario.toml"
    try:
        path.write_bytes(content)
        return _same_again(read_scenario(path))
    finally:
        path.unlink()


TARGETS = {
    "message": Target(_draw_message, _read_message, MessageError, 60),
    "join": Target(_requested(_requests), _read_request, MessageError, 10),
    "reply": Target(_requested(_replies), _read_reply, MessageError, 6),
    "steer": Target(_requested(_steers), _read_steer, MessageError, 6),
    "event": Target(_draw_events, _take_part, MessageError, 2),
    "key": Target(_draw_key, _read_key, KeyGrammarError, 16),
    "document": Target(_draw_document, lambda d: _same_again(parse_document(d)), ScenarioError, 4),
    "text": Target(_draw_text, lambda text: _same_again(parse_toml(text)), ScenarioError, 2),
    "settings": Target(_draw_settings, _read_settings, ScenarioError, 4),
    "file": Target(_draw_file, _read_file, ScenarioError, 2),
    **ORDERS,
    **HOSTS,
    **KEPT,
}
