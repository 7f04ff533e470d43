"""What the world publishes: declared once, counted, and the clock thinned to what a watcher can use."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

import msgspec

from protocol.bus import Bus
from protocol.codec import encode
from protocol.keys import robot_key, world_key
from protocol.messages import Clock, Measurement, Result, Truth
from protocol.streams import STREAMS

CLOCK_PERIOD = 0.05  # s between clocks, unless one is due for its own sake


class Outlet:
    """The world's publishers.

    Attributes:
        published: measurements sent in this turn.
    """

    def __init__(self, bus: Bus, run: str, robots: Iterable[int]) -> None:
        self.published = 0
        self._told = -inf
        self._clock, self._truth, self._result = (
            bus.publisher(STREAMS[name], world_key(run, name)) for name in ("clock", "truth", "result")
        )
        self._measurement = {
            robot: bus.publisher(STREAMS["measurement"], robot_key(run, robot, "measurement"))
            for robot in robots
        }

    def measurements(self, told: Mapping[int, Measurement]) -> None:
        """Tell each robot its own."""
        for robot, measurement in told.items():
            self._measurement[robot](encode(measurement))
        self.published += len(told)

    def clock(self, clock: Clock, *, due: bool) -> None:
        """Tell the time, if it is `due` or the last time was told long enough ago."""
        now = time.monotonic()
        if due or now >= self._told + CLOCK_PERIOD:
            self._told = now
            self._clock(encode(clock))

    def truth(self, truth: Truth) -> None:
        """Tell where everybody is."""
        self._truth(encode(truth))

    def result(self, report: Mapping[str, Any]) -> None:
        """Tell what came of the run."""
        self._result(encode(Result(msgspec.json.encode(report).decode())))
