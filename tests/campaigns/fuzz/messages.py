"""Readers of messages, keys and requests, and what real runs with faults publish, to begin from."""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import count
from random import Random
from unittest.mock import Mock, patch

import msgspec

from agents.peers.state import PeerReader, PeerState
from agents.shell.node import RobotNode
from deploy.library.instances import crash
from deploy.library.load import load
from deploy.processes.supervisor import Supervisor
from deploy.run.assembly import Assembly
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from protocol import joining, keys
from protocol.bus.bus import Event, Presence, Query, Sample
from protocol.bus.local import LocalNetwork
from protocol.codec import REASONS, decode, encode
from protocol.errors import KeyGrammarError, MessageError
from protocol.keys import ROBOT_STREAMS, STREAMS, WORLD_STREAMS, everything, robot_key
from protocol.messages import GoalStatus, State, Wish
from protocol.operations import Steer, decode_steer
from protocol.scenario.model import Scenario
from protocol.scenario.network import Network
from tests.campaigns.campaign import Dice
from tests.campaigns.fuzz.mutation import Target, damaged_message, damaged_text
from tests.campaigns.scenarios.draw import drawn
from tests.deploy.telemetry.monitor.watched import watch_local
from tests.listening import overhear
from world.shell.node import WorldNode

EPOCH = 7  # of all coordinators, so that what one run says counts in another
_KEPT = 40  # valid messages a stream


@cache
def _disturbed() -> Scenario:
    """A fleet with faults, some of whose States are lost; robots come and go."""
    return next(filter(None, (drawn(Dice(seed)) for seed in count(8))))


@cache
def traffic() -> dict[str, list[tuple[str, bytes]]]:
    """Keys and payloads of real runs with faults, by stream."""
    heard: defaultdict[str, list[tuple[str, bytes]]] = defaultdict(list)

    def hear(key: str, payload: bytes) -> None:
        heard[key.rpartition("/")[2]].append((key, payload))

    for scenario in (_disturbed(), crash(0), replace(crash(0), network=Network("near"))):
        with patch("world.shell.node.drawn_epoch", return_value=EPOCH):
            fleet = LocalFleet(scenario, speed=0.0)
        overhear(fleet.network, hear, everything(fleet.run))
        fleet.execute()
    for unsaid, message in (
        ("goalstatus", GoalStatus(1, 3, 2, "under way", (0.5, 0.2), 4)),
        ("wish", Wish(1, (0.1, 0.2))),
    ):
        heard[unsaid].append((robot_key(fleet.run, 1, unsaid), encode(message)))
    assert heard.keys() == STREAMS.keys()
    return {name: sorted(all_)[:: max(1, len(all_) // _KEPT)] for name, all_ in sorted(heard.items())}


def _draw_message(rng: Random) -> tuple[str, bytes]:
    samples = traffic()[rng.choice(tuple(STREAMS))]
    (key, valid), (_, other) = rng.choice(samples), rng.choice(samples)
    if rng.randrange(8) == 0:
        key = draw_key(rng)
    return key, damaged_message(valid, other, rng)


def _read_message(drawn: tuple[str, bytes]) -> None:
    key, payload = drawn
    heard = _heard(key, payload)
    try:
        message = decode(key, payload)
    except MessageError as error:
        assert error.reason in REASONS, error.reason
        assert str(error)
        raise
    assert decode(key, encode(message)) == message
    if isinstance(message, State) and message.epoch == EPOCH:  # a robot hears no other coordinator's
        assert (heard.tick, heard.position, heard.desired) == (
            message.tick,
            message.position,
            message.desired,
        )


def _heard(key: str, payload: bytes) -> PeerState | None:
    """What the robot after the speaker of a State makes of it; None if it refuses."""
    try:
        address = keys.parse(key)
    except KeyGrammarError:
        return None
    if address.stream != "state" or address.robot is None:
        return None
    try:
        return PeerReader(address.robot + 1, address.robot, EPOCH).read(payload)
    except MessageError as error:
        assert error.reason in REASONS, error.reason
        return None


MESSAGES = {"message": Target(_draw_message, _read_message, MessageError, 60)}


@cache
def requests() -> list[bytes]:
    health = decode(*traffic()["health"][-1])
    return [
        joining.encode_request(joining.Join(1, "5f3a", health)),
        joining.encode_request(joining.Join(999, "")),
    ]


@cache
def _replies() -> list[bytes]:
    replies = (
        joining.Admission(3, True, _disturbed(), {1: 1, 2: 3}),
        joining.Refusal("robot 9 is not in this run"),
        joining.Wait(0.2, "another process is joining"),
        joining.Finished("arrived"),
        joining.Overview(crash(0), False),
    )
    return list(map(joining.encode_reply, replies))


@cache
def steers() -> list[bytes]:
    return [msgspec.msgpack.encode(s) for s in (Steer(True, 3, 0.5), {"pause": False}, {"speed": 2}, {})]


def _requested(valid: Callable[[], list[bytes]]) -> Callable[[Random], bytes]:
    return lambda rng: damaged_message(rng.choice(valid()), rng.choice(valid()), rng)


def _read_request(payload: bytes) -> None:
    join = joining.decode_request(1, payload)
    assert joining.decode_request(1, joining.encode_request(join)) == join


JOINING = {
    "join": Target(_requested(requests), _read_request, MessageError, 10),
    "reply": Target(
        _requested(_replies), lambda p: joining.encode_reply(joining.decode_reply(p)), MessageError, 6
    ),
    "steer": Target(_requested(steers), lambda p: msgspec.msgpack.encode(decode_steer(p)), MessageError, 6),
}


def draw_key(rng: Random) -> str:
    run = rng.choice(("demo", "a_b-9", "0", "x" * 60))
    robot = rng.choice((1, 7, 64, 999_999_999))
    valid = rng.choice(
        (f"disknav/{run}/robot/{robot}/{rng.choice(ROBOT_STREAMS)}",
         f"disknav/{run}/world/{rng.choice(WORLD_STREAMS)}",
         keys.robot_token(run, robot, "5c1f"), keys.world_token(run, "A_b-9"))
    )  # fmt: skip
    return damaged_text(valid, f"disknav/{run}/world/alive", rng) if rng.randrange(6) else valid


def _read_key(text: str) -> None:
    run, robot, stream, session = keys.parse.__wrapped__(text)  # uncached: a cache of so many proves nothing
    keys.checked_run(run)
    if session:
        again = keys.world_token(run, session) if robot is None else keys.robot_token(run, robot, session)
    else:
        again = keys.world_key(run, stream) if robot is None else keys.robot_key(run, robot, stream)
    assert again == text


KEYS = {"key": Target(draw_key, _read_key, KeyGrammarError, 16)}


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


def _take_part(drawn: list[_Drawn]) -> None:
    """World, robot, watcher and launcher handle them; the world counts those of unknown robots."""
    network = LocalNetwork()
    bus = network.connect()
    with patch("world.shell.node.drawn_epoch", return_value=EPOCH):
        world = bus.node = WorldNode(bus, _RUN, _participants_of())
    robots = network.connect()
    robot = robots.node = RobotNode(robots, _RUN, 1)
    robot.on_timer(0.0)
    watcher = watch_local(network, _RUN)
    watcher.on_timer(0.0)
    launcher = Fleet(_participants_of(), RunOptions())
    launcher.supervisor = Mock(spec=Supervisor, names=(), **{"running.return_value": ()})  # of no processes
    launcher._assembly = Mock(spec=Assembly)
    handlers: list[Callable[[Event], object]] = [robot.handle, watcher.handle, launcher._take, world.handle]
    for happens, key, payload in drawn:
        if happens == "published":
            event = Sample(key, payload)
        elif happens == "asked":
            event = Query(key, payload, _deaf)
        else:
            event = Presence(key, happens == "appears")
        for handle in handlers[-1:] if happens == "asked" else handlers:
            handle(event)
    watcher.snapshot()
    watcher.overview()
    rejected = world._run.rejected
    if rejected.total():
        raise MessageError(next(iter(rejected)), f"counted: {dict(rejected)}")


PARTICIPANTS = {"event": Target(_draw_events, _take_part, MessageError, 2)}
