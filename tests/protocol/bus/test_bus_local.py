"""The in-process bus keeps the promises of the interface: no echo, presence, requests, order."""

from types import SimpleNamespace

import pytest

from protocol.bus.bus import Event, Presence
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.errors import BusError
from protocol.keys import STREAMS

STATE = STREAMS["state"]


def everything(bus: LocalBus) -> list[Event]:
    return list(iter(lambda: bus.receive(0.0), None))


def test_subscribers_hear_in_order_and_none_hears_itself() -> None:
    network = LocalNetwork()
    one, two, three = network.connect(), network.connect(), network.connect()
    for bus in (one, two):
        bus.subscribe("disknav/r/robot/*/state")
    three.subscribe("disknav/r/robot/2/state")
    publish = one.publisher(STATE, "disknav/r/robot/1/state")
    publish(b"a")
    publish(b"b")
    key = "disknav/r/robot/1/state"
    assert [(sample.key, sample.payload) for sample in everything(two)] == [(key, b"a"), (key, b"b")]
    assert everything(one) == everything(three) == []


def test_presence_comes_with_history_and_goes_with_close() -> None:
    network = LocalNetwork()
    one, two = network.connect(), network.connect()
    one.announce("disknav/r/robot/1/alive")
    two.watch("disknav/r/robot/*/alive")
    one.close()
    one.close()
    assert everything(two) == [Presence("disknav/r/robot/1/alive", alive) for alive in (True, False)]


def test_requests_are_answered_by_the_node_that_serves() -> None:
    network = LocalNetwork()
    one, two = network.connect(), network.connect()
    one.serve("disknav/r/world/scenario")
    one.node = SimpleNamespace(handle=lambda query: query.reply(b"re:" + query.payload))
    assert two.ask("disknav/r/world/scenario", b"x", 1.0) == [b"re:x"]
    with pytest.raises(BusError, match="no answer under"):
        two.ask("disknav/r/world/control", b"", 1.0)


def test_only_those_hear_that_subscribe_for_as_long_as_they_do() -> None:
    network = LocalNetwork()
    one, two, three = network.connect(), network.connect(), network.connect()
    key = "disknav/r/robot/1/health"
    publish = one.publisher(STREAMS["health"], key)
    publish(b"unheard")
    two.subscribe(key)
    two.unsubscribe(key)
    three.subscribe("disknav/r/**")
    publish(b"heard")
    assert [(sample.key, sample.payload) for sample in everything(three)] == [(key, b"heard")]
    three.close()
    publish(b"unheard")
    assert everything(two) == everything(three) == []
