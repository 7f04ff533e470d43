"""The world's publications: declared once and counted; those for monitors are grouped."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from math import inf
from typing import Any

import msgspec

from protocol.bus.bus import Bus, Publish
from protocol.codec import encode
from protocol.keys import STREAMS, robot_key, world_key
from protocol.messages import Clock, GoalStatus, Result, Summary, Tick, Truth

CLOCK_PERIOD = 0.05  # s between publications for monitors, unless one is due earlier


class Publishers:
    """The world's publishers."""

    def __init__(self, bus: Bus, run: str, robots: Iterable[int], epoch: int) -> None:
        self.published = 0  # Ticks sent
        self._epoch = epoch
        self._sent = -inf
        self._clock, self._truth, self._summary, self._result = (
            bus.publisher(STREAMS[name], world_key(run, name))
            for name in ("clock", "truth", "summary", "result")
        )
        self._bus, self._run = bus, run
        self._goal: dict[int, Publish] = {}
        self._tick: dict[int, Publish] = {}
        for robot in robots:
            self.add(robot)

    def add(self, robot: int) -> None:
        """Declare the Ticks of another robot."""
        if robot not in self:
            for name, publishers in (("tick", self._tick), ("goalstatus", self._goal)):
                publishers[robot] = self._bus.publisher(STREAMS[name], robot_key(self._run, robot, name))

    def __contains__(self, robot: object) -> bool:
        """Whether a robot's Ticks are declared."""
        return robot in self._tick

    def goals(self, news: Iterable[GoalStatus]) -> None:
        for status in news:
            self._goal[status.robot](encode(status))

    def summary(self, summary: Summary) -> None:
        self._summary(encode(msgspec.structs.replace(summary, epoch=self._epoch)))

    def ticks(self, ticks: Mapping[int, Tick]) -> None:
        for robot, tick in ticks.items():
            self._tick[robot](encode(msgspec.structs.replace(tick, epoch=self._epoch)))
        self.published += len(ticks)

    @property
    def is_due(self) -> bool:
        """Whether enough time has passed since the last publication for monitors."""
        return time.monotonic() >= self._sent + CLOCK_PERIOD

    def watched(self, clock: Clock, truths: Iterable[Truth]) -> None:
        """Publish the time, and all positions since the last call."""
        self._sent = time.monotonic()
        for truth in truths:
            self._truth(encode(truth))
        self._clock(encode(clock))

    def result(self, report: Mapping[str, Any]) -> None:
        self._result(encode(Result(msgspec.json.encode(report).decode())))
