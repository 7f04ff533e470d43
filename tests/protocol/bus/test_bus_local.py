"""The in-process bus keeps the promises of the interface: no echo, presence, requests, order."""

from random import Random

import pytest

from protocol.bus.bus import Event, Presence, Query, Sample
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.errors import BusError
from protocol.streams import STREAMS
from tests.drawn_order import DrawnNetwork

STATE = STREAMS["state"]


class Listener:
    """A node that keeps what it hears, and answers requests."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.deadline = float("inf")
        self.finished = False

    def handle(self, event: Event) -> None:
        if isinstance(event, Query):
            event.reply(b"re:" + event.payload)
        else:
            self.events.append(event)

    def wake(self, now: float) -> None:
        raise AssertionError("nothing was due")


def everything(bus: LocalBus) -> list[Event]:
    events = []
    while (event := bus.receive(0.0)) is not None:
        events.append(event)
    return events


def test_subscribers_hear_in_order_and_nobody_hears_itself() -> None:
    network = LocalNetwork()
    one, two, three = network.connect(), network.connect(), network.connect()
    for bus in (one, two):
        bus.subscribe("disknav/r/robot/*/state")
    three.subscribe("disknav/r/robot/2/state")
    publish = one.publisher(STATE, "disknav/r/robot/1/state")
    publish(b"a")
    publish(b"b")
    assert everything(two) == [
        Sample("disknav/r/robot/1/state", b"a"),
        Sample("disknav/r/robot/1/state", b"b"),
    ]
    assert everything(one) == everything(three) == []


def test_in_a_drawn_order_each_key_is_heard_in_its_own() -> None:
    network = DrawnNetwork(Random(1))
    ears, mouth = network.connect(), network.connect()
    ears.subscribe("a", "b")
    ears.node = listener = Listener()
    say = [mouth.publisher(STREAMS["state"], key) for key in ("a", "b")]
    for number in range(20):
        for each in say:
            each(bytes([number]))
    network.run(lambda: len(listener.events) == 40)
    heard = [(event.key, event.payload[0]) for event in listener.events if isinstance(event, Sample)]
    assert [number for key, number in heard if key == "a"] == list(range(20))
    assert [number for key, number in heard if key == "b"] == list(range(20))
    assert heard != sorted(heard, key=lambda each: each[1])


def test_a_later_subscription_hears_what_comes_later() -> None:
    network = LocalNetwork()
    one, two = network.connect(), network.connect()
    publish = one.publisher(STATE, "disknav/r/robot/1/state")
    publish(b"early")
    two.subscribe("disknav/r/**")
    publish(b"late")
    assert everything(two) == [Sample("disknav/r/robot/1/state", b"late")]


def test_presence_comes_with_history_and_goes_with_close() -> None:
    network = LocalNetwork()
    one, two = network.connect(), network.connect()
    one.announce("disknav/r/robot/1/alive")
    two.watch("disknav/r/robot/*/alive")
    one.close()
    one.close()
    assert everything(two) == [
        Presence("disknav/r/robot/1/alive", True),
        Presence("disknav/r/robot/1/alive", False),
    ]


def test_requests_are_answered_by_the_node_that_serves() -> None:
    network = LocalNetwork()
    one, two = network.connect(), network.connect()
    one.serve("disknav/r/world/scenario")
    one.node = Listener()
    assert two.ask("disknav/r/world/scenario", b"x", 1.0) == [b"re:x"]
    with pytest.raises(BusError, match="no answer under"):
        two.ask("disknav/r/world/control", b"", 1.0)


def test_the_network_runs_nodes_until_told() -> None:
    network = LocalNetwork()
    one, two = network.connect(), network.connect()
    listener = two.node = Listener()
    two.subscribe("disknav/r/**")
    publish = one.publisher(STATE, "disknav/r/robot/1/state")
    for _ in range(3):
        publish(b"")
    network.run(lambda: len(listener.events) == 3)
    assert len(listener.events) == 3


def test_it_is_known_whether_anybody_hears_a_key() -> None:
    network = LocalNetwork()
    one, two, three = network.connect(), network.connect(), network.connect()
    key = "disknav/r/robot/1/health"
    publish = one.publisher(STREAMS["health"], key)
    publish(b"unheard")
    assert not one.is_heard(key)
    two.subscribe(key)
    assert one.is_heard(key)
    two.unsubscribe(key)
    assert not one.is_heard(key)
    three.subscribe("disknav/r/**")
    assert one.is_heard(key)
    publish(b"heard")
    assert everything(three) == [Sample(key, b"heard")]
    three.close()
    assert not one.is_heard(key)
    publish(b"unheard")
    assert everything(two) == everything(three) == []
