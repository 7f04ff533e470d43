"""A robot's process as a node of ROS 2: its topics on the bus, in the dialect that the scenario chooses."""

from __future__ import annotations

from agents.bases.dialects import EntityKind, Topic, dialect_of
from protocol.bus.bus import Bus, Publish, RawSample
from protocol.keys import driver_token
from protocol.scenario.body import Base


class RosLink:
    """The topics of one robot, by its settings `base`, on the connection of its process."""

    def __init__(self, bus: Bus, base: Base) -> None:
        self._bus, self._dialect = bus, dialect_of(base)
        self._domain = base.domain if base.dialect == "rmw_zenoh" else 0  # no other dialect has any
        self._topics: dict[str, Topic] = {}  # that it subscribes to, by name
        self._number = 0
        self._announce("NN")

    def publisher(self, topic: Topic) -> Publish:
        """Declare a publication; the returned function publishes one payload."""
        token = self._announce("MP", topic)
        return self._bus.raw_publisher(self._dialect.key(topic), self._dialect.attach(token))

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

    def topic_of(self, event: RawSample) -> Topic:
        """The topic of an event; raises MessageError if type, hash or attachment differ."""
        topic = self._topics[self._dialect.name(event.key)]
        self._dialect.check(topic, event.key, event.attachment)
        return topic

    def _announce(self, kind: EntityKind, topic: Topic | None = None) -> str:
        token = self._dialect.token(self._bus.identity, self._number, kind, topic)
        self._number += 1
        if token:
            self._bus.announce(token)
        return token
