"""A zenoh bus for a listener in no hurry: it looks at what has arrived twenty times a second."""

from __future__ import annotations

import time
from collections.abc import Callable

from protocol.bus import Event, Sample
from protocol.bus_zenoh import ZenohBus
from protocol.connection import Connection

_NAP = 0.05  # s between looks


class BurstBus(ZenohBus):
    """`ZenohBus` whose `receive` never wakes for a single sample: that is most of what hearing costs."""

    def __init__(self, connection: Connection) -> None:
        super().__init__(connection)
        self._channels: list[Callable[[], Sample | None]] = []

    def subscribe(self, key_expression: str) -> None:
        self._channels.append(self.channel(key_expression))

    def receive(self, timeout: float) -> Event | None:
        event = self._waiting()
        if event is None and timeout > 0.0:
            time.sleep(min(timeout, _NAP))
            event = self._waiting()
        return event

    def _waiting(self) -> Event | None:
        for channel in self._channels:
            sample = channel()
            if sample is not None:
                return sample
        return super().receive(0.0)
