"""The MCAP file of a run: one JSON channel a key, a scene of it all, scenario and result as metadata."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from deploy.telemetry.recording.form import schema, to_object
from deploy.telemetry.recording.mcap.file import McapFile
from deploy.telemetry.recording.pictures import Pictures
from protocol.codec import Reader
from protocol.errors import KeyGrammarError, MessageError, RecordingError, UsageError
from protocol.keys import Address, parse
from protocol.messages import VERSION, Truth
from protocol.scenario.model import Scenario
from protocol.streams import STREAMS

LIBRARY = "disknav"
_TOGETHER = 512  # messages that are encoded together
_LATEST = float(1 << 63)  # ns, of what a reader takes; no tick of a real run is later
_JSON = msgspec.json.Encoder()


class _Channel:
    """What is written under one key.

    Attributes:
        number: of the channel in the file.
        read: makes a message of a payload, see `Reader`.
        form: turns a message into what JSON writes.
    """

    def __init__(self, address: Address, number: int) -> None:
        self.stream, self.number = address.stream, number
        self.read = Reader(address.stream, address.robot).read
        self.form = to_object(STREAMS[address.stream].message)


class RecordingFile:
    """A recording that is being written.

    Attributes:
        rejected: payloads that were no messages of this run, by reason; they are not recorded.

    Raises:
        UsageError: the file cannot be created.
        RecordingError: (all methods) it cannot be written any more.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rejected: Counter[str] = Counter()
        self._channels: dict[str, _Channel | None] = {}
        self._schemas: dict[str, int] = {}
        self._robots: frozenset[int] = frozenset()
        self._run = ""
        self._step = 0.0
        self._count = 0
        self._report: str | None = None
        self._pictures: Pictures | None = None
        try:
            self._file = McapFile(path, LIBRARY)
        except OSError as error:
            raise UsageError(
                f"cannot record to {path}: {error.strerror}; name a file that can be written"
            ) from error

    def begin(self, run: str, scenario: Scenario, preceding: str = "") -> None:
        """Say what is recorded; comes before every message, and is heard once.

        `preceding` is the name of the file that this one goes on from.
        """
        if self._run:
            return
        self._robots = frozenset((*scenario.ids, *(spec.id for spec in scenario.newcomers)))
        self._run, self._step = run, scenario.time.step
        with self._writing():
            before = {"preceding": preceding} if preceding else {}
            self._file.metadata("run", {"name": run, "protocol": str(VERSION), **before})
            self._file.metadata("scenario", {"json": _JSON.encode(scenario).decode()})
            self._pictures = Pictures(self._file, scenario)
            self._file.flush()

    def write(self, batch: Sequence[tuple[str, bytes]]) -> None:
        """Record what was published, at the simulated time of its tick; the result waits for `finish`."""
        with self._writing():
            for start in range(0, len(batch), _TOGETHER):
                self._add(*self._read(batch[start : start + _TOGETHER]))

    def _read(self, batch: Sequence[tuple[str, bytes]]) -> tuple[list[_Channel], list[Any]]:
        """The messages and the channel of each; all else is counted."""
        channels: list[_Channel] = []
        messages: list[Any] = []
        for key, payload in batch:
            try:
                channel = self._channels.get(key) or self._open(key)
                if channel is not None:
                    messages.append(channel.read(payload))
                    channels.append(channel)
            except MessageError as error:
                self.rejected[error.reason] += 1
            except KeyGrammarError:
                self.rejected["key"] += 1
        return channels, messages

    def _add(self, channels: list[_Channel], messages: list[Any]) -> None:
        """Record messages, each under its channel."""
        lines = _JSON.encode_lines(
            [channel.form(message) for channel, message in zip(channels, messages, strict=True)]
        )
        ticks = np.array([message.tick for message in messages], np.float64)
        times = np.rint(ticks * self._step * 1e9).clip(max=_LATEST).astype(np.uint64)
        self._file.messages([channel.number for channel in channels], times, lines)
        self._count += len(messages)
        for message in messages:
            if type(message) is Truth and not self._robots.issuperset(message.robots):
                self._robots = self._robots.union(message.robots)  # an operator added some
        if self._pictures is not None:
            self._pictures.hear(messages)

    def _open(self, key: str) -> _Channel | None:
        """The channel of a key; None for streams that are no part of a recording."""
        if key in self._channels:
            return self._channels[key]
        address = parse(key)
        if address.run != self._run or (address.robot is not None and address.robot not in self._robots):
            raise MessageError("key", f"{key} is not a key of run {self._run!r}")
        stream = STREAMS.get(address.stream)
        if stream is None:
            raise MessageError("key", f"{key} carries no messages")
        self._channels[key] = None
        if stream.recorded:
            if stream.name not in self._schemas:
                text = json.dumps(schema(stream.message)).encode()
                self._schemas[stream.name] = self._file.schema(f"disknav.{stream.message.__name__}", text)
            number = self._file.channel(key, self._schemas[stream.name], {"rate": stream.rate})
            self._channels[key] = _Channel(address, number)
        return self._channels[key]

    def flush(self) -> None:
        """Close the present chunk: what was added can be read whatever happens to this process."""
        with self._writing():
            self._file.flush()

    def report(self, result: str) -> None:
        """What the world says of the run (a JSON object), should nobody know more."""
        self._report = result

    @property
    def size(self) -> int:
        """Bytes written so far."""
        return self._file.size

    def finish(self, result: str | None = None, following: str = "") -> None:
        """Write the result (a JSON object) and the index; nothing can be added afterwards.

        `following` is the name of the file in which the recording goes on.
        """
        with self._writing():
            self._end(result, {"following": following} if following else {})

    def abandon(self, reason: str, result: str | None = None) -> None:
        """Close what was written before it could not be written any more, with the reason in it."""
        with self._writing():
            self._file.abandon()
            self._end(result, {"ended": reason})

    def _end(self, result: str | None, said: dict[str, str]) -> None:
        text = result or self._report
        known = {} if text is None else {"result": {"json": text}}
        counts = {"messages": str(self._count), "rejected": json.dumps(self.rejected)}
        self._file.finish({**known, "recorder": {**counts, **said}})

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise RecordingError(f"cannot go on recording to {self.path}: {error.strerror}") from error
