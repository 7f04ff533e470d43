"""Fleets in this process whose robots join, and whose messages are heard, in an order of their own."""

from collections import deque
from collections.abc import Sequence
from random import Random
from typing import Any

from deploy.run.local import LocalFleet
from protocol.bus.bus import Event
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.scenario.model import Scenario


class DrawnNetwork(LocalNetwork):
    """Draws which node is next, and which message it receives: of each key in the order of publication, as on
    any network."""

    def __init__(self, order: Random) -> None:
        super().__init__()
        self.order = order

    def connect(self) -> LocalBus:
        bus = DrawnBus(self)
        self._buses.append(bus)
        return bus

    def next_of(self, ready: deque[LocalBus]) -> LocalBus:
        ready.rotate(self.order.randrange(len(ready)))
        return ready.popleft()


class DrawnBus(LocalBus):
    def drain(self) -> None:
        if self.node is not None and self.inbox:
            self.node.handle(_drawn(self.inbox, self.network.order))
        if self.node is not None and self.inbox:
            self.network.notify(self)


def _drawn(inbox: deque[Event], order: Random) -> Event:
    """Take out the first event of any key."""
    first: dict[str, int] = {}
    for place, event in enumerate(inbox):
        first.setdefault(event.key, place)
    place = order.choice(list(first.values()))
    drawn = inbox[place]
    del inbox[place]
    return drawn


class ReorderedFleet(LocalFleet):
    """Robots join in the order of `joining`, at the start and whenever several join again; those that are not
    named come last, in decreasing order."""

    def __init__(self, scenario: Scenario, joining: Sequence[int], **others: Any) -> None:
        self._joining = joining
        super().__init__(scenario, **others)

    def turn(self, robot: int) -> tuple[bool, int]:
        return (False, self._joining.index(robot)) if robot in self._joining else (True, -robot)
