"""Participants of a bus in this process that only listen."""

from collections.abc import Callable
from math import inf

from protocol.bus.bus import Event, Sample
from protocol.bus.local import LocalBus, LocalNetwork


class _Ear:
    finished, deadline = False, inf

    def __init__(self, hear: Callable[[str, bytes], object]) -> None:
        self._hear = hear

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            self._hear(event.key, event.payload)

    def on_timer(self, now: float) -> None:
        """Nothing is due by the wall clock."""


def overhear(network: LocalNetwork, hear: Callable[[str, bytes], object], *keys: str) -> LocalBus:
    """Have `hear` told what is published under these keys; the participant that it is told by."""
    bus = network.connect()
    bus.subscribe(*keys)
    bus.node = _Ear(hear)
    return bus
