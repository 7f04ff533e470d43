"""The in-process bus: all nodes of a run in one thread, with the messages and codec that they have on zenoh.

Events wait in one inbox per participant, and `LocalNetwork.run` lets each participant empty its own in turn.
"""

from __future__ import annotations

import re
import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from functools import partial

from protocol.bus.bus import Event, Node, Presence, Publish, Query, RawSample, Sample
from protocol.errors import BusError
from protocol.keys import Stream

_LONGEST_SLEEP = 0.1


class LocalNetwork:
    """The network of local buses. Buses take turns, and each receives events in the order of sending."""

    def __init__(self) -> None:
        self._buses: list[LocalBus] = []
        self.listeners: list[LocalBus] = []  # subscribers to patterns
        self._ready: deque[LocalBus] = deque()
        self.routes: defaultdict[str, list[LocalBus]] = defaultdict(list)  # subscribers to each plain key

    def connect(self) -> LocalBus:
        """A new participant."""
        bus = LocalBus(self)
        self._buses.append(bus)
        return bus

    def run(self, finished: Callable[[], bool]) -> None:
        """Deliver events and call timers until `finished`; sleeps while nothing is due.

        A node with an immediate deadline is called after its events, however busy the others are.
        """
        while not finished():
            if not self._ready:
                self._wait()
                continue
            bus = self.next_of(self._ready)
            bus.drain()
            node = bus.node
            if node is not None and not node.finished and node.deadline <= (now := time.monotonic()):
                node.on_timer(now)

    def next_of(self, ready: deque[LocalBus]) -> LocalBus:
        """Remove and return the participant whose events are delivered next."""
        return ready.popleft()

    def _wait(self) -> None:
        nodes = [bus.node for bus in self._buses if bus.node is not None and not bus.node.finished]
        now = time.monotonic()
        for node in nodes:
            if node.deadline <= now:
                node.on_timer(now)
        if not self._ready:
            pause = min((node.deadline for node in nodes), default=now) - time.monotonic()
            time.sleep(min(max(pause, 0.0), _LONGEST_SLEEP))

    def watchers(self, key: str) -> list[LocalBus]:
        """Subscribers to a pattern that `key` matches."""
        return [bus for bus in self.listeners if _matches(bus.patterns, key)]

    def notify(self, bus: LocalBus) -> None:
        """Note that `bus` has something in its inbox."""
        self._ready.append(bus)

    def tokens(self) -> list[str]:
        """Keys of all liveliness tokens."""
        return [key for bus in self._buses for key in bus.announced]

    def publish_presence(self, key: str, alive: bool, sender: LocalBus) -> None:
        """Report that a token appeared or disappeared."""
        for bus in self._buses:
            if bus is not sender and _matches(bus.watched, key):
                bus.put(Presence(key, alive))

    def servers(self, key: str) -> list[Node]:
        """Nodes that answer requests under `key`."""
        return [bus.node for bus in self._buses if bus.node is not None and _matches(bus.served, key)]

    def leave(self, bus: LocalBus) -> None:
        """Remove a closed `bus` with its tokens and subscriptions."""
        if bus in self._buses:
            self._buses.remove(bus)
            if bus in self.listeners:
                self.listeners.remove(bus)
            for key in bus.keys:
                self.routes[key].remove(bus)
            for key in bus.announced:
                self.publish_presence(key, False, bus)


class LocalBus:
    """One participant's connection to a LocalNetwork; implements `protocol.bus.bus.Bus`."""

    def __init__(self, network: LocalNetwork) -> None:
        self.node: Node | None = None
        self.announced: list[str] = []
        self.served: list[re.Pattern[str]] = []
        self.network = network
        self.inbox: deque[Event] = deque()
        self.keys: set[str] = set()
        self.patterns: list[re.Pattern[str]] = []
        self.watched: list[re.Pattern[str]] = []

    def publisher(self, stream: Stream, key: str) -> Publish:  # noqa: ARG002
        return self._publish(key, partial(Sample, key))

    @property
    def identity(self) -> str:
        return f"{id(self):x}"

    def raw_publisher(self, key: str, attach: Callable[[], bytes] | None = None) -> Publish:
        beside = bytes if attach is None else attach
        return self._publish(key, lambda payload: RawSample(key, payload, beside()))

    def _publish(self, key: str, event: Callable[[bytes], Event]) -> Publish:
        network, route = self.network, self.network.routes[key]

        def publish(payload: bytes) -> None:
            sample = event(payload)
            for bus in route:
                if bus is not self:
                    bus.put(sample)
            for bus in network.watchers(key):
                if bus is not self and bus not in route:
                    bus.put(sample)

        return publish

    def subscribe(self, *key_expressions: str) -> None:
        for each in key_expressions:
            if "*" in each:
                if not self.patterns:
                    self.network.listeners.append(self)
                self.patterns.append(_pattern(each))
            elif self not in (route := self.network.routes[each]):
                route.append(self)
                self.keys.add(each)

    def listen(self, key_expression: str) -> None:
        self.subscribe(key_expression)

    def unsubscribe(self, key: str) -> None:
        if key in self.keys:
            self.keys.discard(key)
            self.network.routes[key].remove(self)

    def expect(self, keys: Iterable[str]) -> None:
        pass

    def watch(self, key_expression: str) -> None:
        self.watched.append(_pattern(key_expression))
        for key in self.tokens(key_expression):
            self.put(Presence(key, True))

    def serve(self, key: str) -> None:
        self.served.append(_pattern(key))

    def announce(self, key: str) -> None:
        self.announced.append(key)
        self.network.publish_presence(key, True, self)

    def ask(self, key: str, payload: bytes, timeout: float, *, once: bool = False) -> list[bytes]:  # noqa: ARG002
        """In one thread no other node can act meanwhile: replies come at once or never."""
        replies: list[bytes] = []
        for node in self.network.servers(key):
            node.handle(Query(key, payload, replies.append))
        if not replies:
            raise BusError(f"no answer under {key}")
        return replies

    def post(self, key: str, payload: bytes) -> None:
        for node in self.network.servers(key):
            node.handle(Query(key, payload, lambda reply: self.put(RawSample(key, reply))))

    def tokens(self, key_expression: str) -> list[str]:
        pattern = _pattern(key_expression)
        return [key for key in self.network.tokens() if pattern.fullmatch(key)]

    def receive(self, timeout: float) -> Event | None:  # noqa: ARG002
        return self.inbox.popleft() if self.inbox else None

    def close(self) -> None:
        self.network.leave(self)
        self.inbox.clear()
        self.node = None

    def put(self, event: Event) -> None:
        """Add an event to the inbox."""
        if not self.inbox:
            self.network.notify(self)
        self.inbox.append(event)

    def drain(self) -> None:
        """Let the node handle all events of the inbox."""
        node, inbox = self.node, self.inbox
        while node is not None and inbox:
            node.handle(inbox.popleft())
            node = self.node


def _matches(patterns: Iterable[re.Pattern[str]], key: str) -> bool:
    return any(pattern.fullmatch(key) for pattern in patterns)


def _pattern(key_expression: str) -> re.Pattern[str]:
    """A regular expression for a zenoh key expression made of plain chunks, `*` and a final `**`."""
    chunks = key_expression.split("/")
    parts = [".*" if chunk == "**" else "[^/]+" if chunk == "*" else re.escape(chunk) for chunk in chunks]
    return re.compile("/".join(parts))
