"""A robot's process as a node of ROS 2: its topics on the bus, in the dialect that the scenario chooses."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from agents.bases.base import Shown
from agents.bases.dialects import Kind, Topic, dialect_of
from agents.robot import Robot
from protocol.bus.bus import Bus, Foreign, Publish
from protocol.errors import MessageError
from protocol.keys import driver_token
from protocol.messages import Command
from protocol.operations import Outcome, decode_reply
from protocol.scenario.body import Base

if TYPE_CHECKING:
    from agents.bases.tools import RosTools


class RosLink:
    """The topics of one robot.

    Args:
        bus: the process's own connection.
        base: the scenario's settings of these topics, for this robot.
    """

    def __init__(self, bus: Bus, base: Base) -> None:
        self._bus, self._dialect = bus, dialect_of(base)
        self._domain = base.domain if base.dialect == "rmw_zenoh" else 0  # no other dialect has any
        self._topics: dict[str, Topic] = {}  # that it subscribes to, by name
        self._number = 0
        self._announce("NN")

    def publisher(self, topic: Topic) -> Publish:
        """Declare a publication; the returned function publishes one payload."""
        token = self._announce("MP", topic)
        return self._bus.foreign(self._dialect.key(topic), self._dialect.attach(token))

    def claim(self, topic: Topic) -> str:
        """Announce this process as publisher of a topic and watch for others; returns the token."""
        name = f"{self._domain}/{topic.name}"
        own = driver_token(name, self._bus.identity)
        self._bus.watch(driver_token(name, "*"))
        self._bus.announce(own)
        return own

    def subscribe(self, *topics: Topic) -> None:
        """Subscribe to topics; `topic_of` assigns events of the bus to them."""
        for topic in topics:
            self._topics[topic.name] = topic
            self._bus.listen(self._dialect.expression(topic))
            self._announce("MS", topic)

    def topic_of(self, event: Foreign) -> Topic:
        """The topic of an event; raises MessageError without one, or if type, hash or attachment differ."""
        topic = self._topics.get(self._dialect.name(event.key))
        if topic is None:
            raise MessageError("key", f"{event.key} is no topic of this robot")
        self._dialect.check(topic, event.key, event.attachment)
        return topic

    def _announce(self, kind: Kind, topic: Topic | None = None) -> str:
        token = self._dialect.token(self._bus.identity, self._number, kind, topic)
        self._number += 1
        if token:
            self._bus.announce(token)
        return token


class AttachedTools:
    """A robot's topics for tools of ROS, on the bus.

    Args:
        tools: makes the payloads to publish, and reads those received.
        link: carries its topics.
        bus: the process's own connection.
        operations: the key under which the world takes operations.
        say: takes warnings for the operator.
    """

    def __init__(
        self, tools: RosTools, link: RosLink, bus: Bus, operations: str, say: Callable[[str], None]
    ) -> None:
        self._tools, self._bus, self._operations, self._say = tools, bus, operations, say
        link.subscribe(*tools.hears)
        self._publish = {topic: link.publisher(topic) for topic in tools.tells}

    def hear(self, topic: Topic, payload: bytes) -> None:
        """Receive a message; raises MessageError."""
        before = self._tools.stopped
        if request := self._tools.hear(topic, payload):
            self._bus.post(self._operations, request)
        if self._tools.stopped != before:
            self._say(f"{topic.name} says {'stop; stands' if self._tools.stopped else 'go'}")

    def is_reply(self, event: Foreign) -> bool:
        """Whether an event is the world's reply to an operation; reports a refusal to the operator."""
        if event.key != self._operations:
            return False
        outcome = decode_reply(event.payload, Outcome)
        if not outcome.accepted:
            self._say(f"a goal is refused: {outcome.text}")
        return True

    @property
    def stopped(self) -> bool:
        """Whether the robot must stand until it is released."""
        return self._tools.stopped

    def tell(self, core: Robot, command: Command, heading: float) -> None:
        """Publish the payloads that are due, after a Command of a robot with `heading`, rad."""
        now, (position, bound) = time.monotonic(), core.place
        if position is None or not self._tools.is_due(now):
            return
        shown = Shown(position, bound, heading, command.velocity, core.radius, core.goal, core.lines)
        for topic, payload in self._tools.tell(shown, now):
            self._publish[topic](payload)
