"""What the page is sent: an overview when a scenario begins, then frames, the newest only."""

from __future__ import annotations

import asyncio
import time

import msgspec

from deploy.telemetry.monitor.source import Source

FRAME_PERIOD = 0.05  # s
_REST = 0.01  # s between two looks at least


class FrameStream:
    """Looks at a source at most once in `FRAME_PERIOD`, however many viewers there are, and not without any.

    A viewer that cannot keep up misses frames; nothing is kept for it, and nobody waits for it.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._frame = b""
        self._number = 0
        self._epoch = -1
        self._overview = b""
        self._fresh = asyncio.Condition()
        self._viewers = 0
        self._looking: asyncio.Task[None] | None = None

    def enter(self) -> None:
        """A viewer has come."""
        self._viewers += 1
        if self._looking is None:
            self._looking = asyncio.create_task(self._look())

    def leave(self) -> None:
        """A viewer has gone."""
        self._viewers -= 1

    def overview(self) -> tuple[int, bytes]:
        """Epoch and text for somebody who knows nothing of it yet."""
        overview = self._source.overview()
        return overview["epoch"], msgspec.json.encode(overview)

    async def after(self, number: int) -> tuple[int, int, bytes]:
        """The newest frame, once it is newer than `number`: its number, epoch and text."""
        async with self._fresh:
            await self._fresh.wait_for(lambda: self._number > number)
            return self._number, self._epoch, self._frame

    async def _look(self) -> None:
        since, due = -1, time.monotonic()
        while self._viewers:
            frame = self._source.snapshot(since)
            if frame["epoch"] != self._epoch:
                since = -1
            if frame["samples"]:
                since = frame["samples"][-1][0]
            async with self._fresh:
                self._number, self._epoch = self._number + 1, frame["epoch"]
                self._frame = msgspec.json.encode(frame)
                self._fresh.notify_all()
            due = max(due + FRAME_PERIOD, time.monotonic() + _REST)  # to look takes a while, too
            await asyncio.sleep(due - time.monotonic())
        self._looking = None
