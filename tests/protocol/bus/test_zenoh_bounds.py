"""What zenoh's bus does when others do not do their part: no wait is without end, and no queue."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from protocol.bus.bus import Event, Presence
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError, EndpointTakenError
from protocol.streams import STREAMS

pytestmark = pytest.mark.timeout(30)

STATE, ALIVE = "disknav/t/robot/1/state", "disknav/t/robot/1/alive"
SCENARIO = "disknav/t/world/scenario"
PATIENCE = 10.0
Connect = Callable[..., ZenohBus]


@pytest.mark.parametrize("served", [False, True])
def test_an_unanswered_request_ends_in_time(connect: Connect, served: bool) -> None:
    if served:
        connect().serve(SCENARIO)  # by a process that never receives
    begin = time.monotonic()
    with pytest.raises(BusError, match=SCENARIO):
        connect().ask(SCENARIO, b"may I?", 0.3)
    assert time.monotonic() - begin < 8.0  # zenoh by itself would wait for 10 s


@pytest.mark.parametrize("timeout", [0.0, 0.05])
def test_receiving_is_bounded(connect: Connect, timeout: float) -> None:
    bus = connect()
    begin = time.monotonic()
    assert bus.receive(timeout) is None
    assert timeout <= time.monotonic() - begin < PATIENCE


def test_a_flood_is_shed_and_counted(connect: Connect) -> None:
    speaker, listener = connect(), connect(capacity=8)
    listener.subscribe(STATE)
    listener.watch(ALIVE)
    publish = speaker.publisher(STREAMS["state"], STATE)
    speaker.announce(ALIVE)
    assert listener.receive(PATIENCE) == Presence(ALIVE, True)
    for number in range(20):
        publish(bytes([number]))
    speaker.close()
    deadline = time.monotonic() + PATIENCE
    while listener._queue.qsize() < 21 and time.monotonic() < deadline:  # and that its token is gone
        time.sleep(0.005)
    heard: list[Event] = []
    while len(heard) + listener.dropped < 21:
        event = listener.receive(PATIENCE)
        assert event is not None
        heard.append(event)
    assert len(heard) + listener.dropped == 21
    assert listener.dropped > 0


def test_an_unreachable_router_is_named() -> None:
    nowhere = "tcp/127.0.0.1:9"
    begin = time.monotonic()
    with pytest.raises(BusError, match=nowhere) as raised:
        ZenohBus(Connection(connect=(nowhere,), timeout=0.3))
    assert ".rs" not in str(raised.value)
    assert time.monotonic() - begin < PATIENCE


def test_a_taken_endpoint_is_told_from_other_failures(endpoint: str) -> None:
    with pytest.raises(EndpointTakenError, match=endpoint):
        ZenohBus(Connection("router", listen=(endpoint,)))


def test_closing_twice_is_allowed(connect: Connect) -> None:
    bus = connect()
    bus.close()
    bus.close()
