"""Whatever bytes or numbers come under any key: a valid message, or one that is refused and counted."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from agents.shell.node import RobotNode
from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.bus.bus import Sample
from protocol.codec import encode
from protocol.keys import ROBOT_STREAMS
from protocol.messages import VERSION, Tick
from protocol.streams import STREAMS
from tests.protocol.sample_messages import ANY

NUMBERS = st.floats(allow_nan=True, allow_infinity=True, width=64) | st.sampled_from(
    (math.nan, math.inf, -math.inf, 5e-324, 1e308, -1e308, 1e15, 1e99)
)


@cache
def fleet() -> LocalFleet:
    """Robots that have driven for some ticks."""
    found = LocalFleet(load("swap-2"))
    for _ in range(5):
        found.step()
    return found


def addressed(stream: str, array: list[Any]) -> list[Any]:
    """As it would come from this run: to or of its robots, in their lives, of their coordinator."""
    epoch, tick = fleet().world._epoch, fleet().world.world.tick
    fields = STREAMS[stream].message.__struct_fields__
    known = {"robot": 2 if stream == "state" else 1, "incarnation": 1, "epoch": epoch, "tick": tick}
    for name, value in known.items():
        if name in fields and fields.index(name) + 1 < len(array):
            array[fields.index(name) + 1] = value
    return array


def with_numbers(value: Any, data: st.DataObject) -> Any:
    """The same with other floats in the place of some."""
    if isinstance(value, float):
        return data.draw(NUMBERS | st.just(value))
    return [with_numbers(each, data) for each in value] if isinstance(value, list) else value


def deliver(stream: str, payload: bytes) -> None:
    """Each participant takes it, or counts it."""
    where = "robot/{}" if stream in ROBOT_STREAMS else "world"
    key = f"disknav/local/{where.format(2 if stream == 'state' else 1)}/{stream}"
    world, robot = fleet().world, fleet().robots[1].node
    assert isinstance(robot, RobotNode)
    heard = robot._received + sum(robot._rejected.values())
    robot.handle(Sample(key, payload))
    assert robot._received + sum(robot._rejected.values()) > heard
    heard = world._run.received + sum(world._run.rejected.values())
    world.handle(Sample(key, payload))
    assert world._run.received + sum(world._run.rejected.values()) > heard


@given(st.sampled_from(sorted(set(STREAMS) - {"tick"})).flatmap(lambda name: ANY[name]), st.data())
def test_any_numbers(message: Any, data: st.DataObject) -> None:
    stream = type(message).__name__.lower()
    array = msgspec.msgpack.decode(encode(message))
    deliver(stream, msgspec.msgpack.encode(with_numbers(addressed(stream, array), data)))


@given(st.sampled_from(sorted(STREAMS)), st.binary(max_size=100))
def test_any_bytes(stream: str, payload: bytes) -> None:
    deliver(stream, payload)


def test_a_member_that_stands_nowhere_is_refused() -> None:
    robot, world = fleet().robots[1].node, fleet().world
    assert isinstance(robot, RobotNode)
    roster = [99, [[1, 1, "live", 0.04], [2, 1, "standing", 0.04, None]]]
    array = [f"tick/{VERSION}", 1, 1, world.world.tick + 1, [1, 2], world._epoch, None, False, roster]
    before = robot._rejected["shape"]
    robot.handle(Sample("disknav/local/robot/1/tick", msgspec.msgpack.encode(array)))
    assert robot._rejected["shape"] == before + 1


def test_a_tick_of_an_earlier_life_does_not_shorten_whom_a_robot_awaits() -> None:
    here = LocalFleet(load("swap-4"))
    here.step()
    node = here.robots[1].node
    assert isinstance(node, RobotNode)
    core = node.core
    assert core is not None
    core.incarnation = 2  # a life of this process began within the tick
    here.world_bus.node = None
    node._commanded = False
    core.hearing._awaited = {2, 3, 4}
    node.handle(Sample("disknav/local/robot/1/tick", encode(Tick(1, 1, core.tick, (1, 2), core.epoch))))
    assert core.hearing.missing == [2, 3, 4]
    node.handle(Sample("disknav/local/robot/1/tick", encode(Tick(1, 2, core.tick, (1, 2), core.epoch))))
    assert core.hearing.missing == [2]
