"""Writing the MCAP files of a run: a JSON channel per key, a scene, and scenario and result as metadata."""

from __future__ import annotations

import json
import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import count
from math import inf
from pathlib import Path
from typing import Any, cast

import msgspec
from mcap.writer import Writer

from deploy.telemetry.live import VIEWED, FleetView
from deploy.telemetry.recording.form import schema, to_object
from deploy.telemetry.scene import TOPICS, FleetScene, Picture
from protocol.codec import read
from protocol.errors import KeyGrammarError, MessageError, RecordingError, UsageError
from protocol.keys import STREAMS, Address, parse
from protocol.messages import VERSION, Truth
from protocol.process.log import LOG
from protocol.scenario.model import Scenario

_BYTES = {"kB": 10**3, "MB": 10**6, "GB": 10**9}
_SECONDS = {"s": 1, "min": 60, "h": 3600, "d": 86400}
_FORM = re.compile(rf"(\d+(?:\.\d+)?)({'|'.join((*_BYTES, *_SECONDS))})")


@dataclass(frozen=True)
class Rotation:
    """Start another file after `size` bytes or `age` s of wall clock."""

    size: float = inf
    age: float = inf

    def due(self, size: int, age: float) -> bool:
        return size >= self.size or age >= self.age


ONE_FILE = Rotation()


def rotation(given: Sequence[str]) -> Rotation:
    """Parse the values of `--rotate`: `500MB`, `1h`, or one of each; raises UsageError."""
    size = age = inf
    for text in given:
        found = _FORM.fullmatch(text)
        if found is None or not float(found[1]):
            units = ", ".join((*_BYTES, *_SECONDS))
            raise UsageError(f"--rotate {text!r}: give a number and a unit ({units}), such as 500MB or 1h")
        if found[2] in _BYTES:
            size = min(size, float(found[1]) * _BYTES[found[2]])
        else:
            age = min(age, float(found[1]) * _SECONDS[found[2]])
    return Rotation(size, age)


def next_free(path: Path) -> Path:
    """First unused name of `run-2.mcap`, `run-3.mcap`, ... beside `run.mcap`."""
    parts = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(part for part in parts if not part.exists())


LIBRARY = "disknav"
_CHUNK = 256 * 1024  # bytes before compression; one damaged byte costs at most a chunk
_BUFFER = 1 << 20  # bytes, so that header, scenario and scene are one write
_LATEST = 1 << 63  # ns, end of MCAP's time
_JSON = msgspec.json.Encoder()


class _Channel:
    """One key of the run."""

    def __init__(self, address: Address, number: int) -> None:
        self.number, self.count = number, 0  # of the channel in the file; messages written so far
        self.read = partial(read, address.stream, address.robot)  # decodes a payload


class RecordingFile:
    """One MCAP file of a run, open for writing.

    Args:
        path: created, or overwritten.
        preceding: name of the file that this one continues; empty for the first.

    Raises:
        UsageError: the file cannot be created.
        RecordingError: (all methods) writing fails.
    """

    def __init__(self, path: Path, run: str, scenario: Scenario, preceding: str = "") -> None:
        self.path = path
        self.rejected: Counter[str] = Counter()  # invalid payloads, by reason; they are not recorded
        self._run, self._step = run, scenario.time.step
        self._robots = frozenset((*scenario.ids, *(spec.id for spec in scenario.newcomers)))
        self._channels: dict[str, _Channel | None] = {}
        self._schemas: dict[str, int] = {}
        self._count = 0
        try:
            self._stream = path.open("wb", _BUFFER)
        except OSError as error:
            raise UsageError(
                f"cannot record to {path}: {error.strerror}; name a file that can be written"
            ) from error
        with self._writing():
            self._writer = cast("Any", Writer(self._stream, _CHUNK))  # partly untyped
            self._writer.start(library=LIBRARY)
            before = {"preceding": preceding} if preceding else {}
            self._writer.add_metadata("run", {"name": run, "protocol": str(VERSION), **before})
            self._writer.add_metadata("scenario", {"json": _JSON.encode(scenario).decode()})
            self._view = FleetView(run, recent=1)
            self._view.begin(scenario, lockstep=True)
            self._scene = FleetScene(self._view)
            self._topics = {name: self._register(name, *topic, {}) for name, topic in TOPICS.items()}
            self._draw(self._scene.whole())
            self._writer.flush()

    def write(self, batch: Iterable[tuple[str, bytes]]) -> None:
        """Record payloads by key, at the simulated time of their ticks."""
        with self._writing():
            for key, payload in batch:
                try:
                    channel = self._channels[key] if key in self._channels else self._open(key)
                    if channel is not None:
                        self._add(channel, channel.read(payload))
                except MessageError as error:
                    self.rejected[error.reason] += 1
                except KeyGrammarError:
                    self.rejected["key"] += 1

    def flush(self) -> int:
        """Close the chunk, which stays readable even if this process is killed. Returns the file's size."""
        with self._writing():
            self._writer.flush()
            return self._stream.tell()

    def finish(self, result: str | None = None, following: str = "") -> None:
        """Write the result (a JSON object) and the index, and close the file.

        `following` is the name of the file that continues the recording.
        """
        with self._writing():
            if result is not None:
                self._writer.add_metadata("result", {"json": result})
            counts = {"messages": str(self._count), "rejected": json.dumps(self.rejected)}
            self._writer.add_metadata("recorder", counts | ({"following": following} if following else {}))
            self._writer.finish()
            self._stream.close()

    def _add(self, channel: _Channel, message: Any) -> None:
        when = min(round(message.tick * self._step * 1e9), _LATEST)
        data = _JSON.encode(to_object(message))
        self._writer.add_message(channel.number, when, data, when, channel.count)
        channel.count += 1
        self._count += 1
        if isinstance(message, Truth) and not self._robots.issuperset(message.robots):
            self._robots = self._robots.union(message.robots)  # added by an operator
        if type(message) in VIEWED:
            self._view.on_message(message, 0.0)
            self._draw(self._scene.after(message))

    def _draw(self, pictures: Iterable[Picture]) -> None:
        for topic, when, data in pictures:
            self._writer.add_message(self._topics[topic], when, data, when)

    def _open(self, key: str) -> _Channel | None:
        """Channel of a key; None for streams that are not recorded."""
        address = parse(key)
        if address.run != self._run or (address.robot is not None and address.robot not in self._robots):
            raise MessageError("key", f"{key} is not a key of run {self._run!r}")
        stream = STREAMS.get(address.stream)
        if stream is None:
            raise MessageError("key", f"{key} carries no messages")
        self._channels[key] = None
        if stream.recorded:
            name, form = f"disknav.{stream.message.__name__}", schema(stream.message)
            number = self._register(key, name, json.dumps(form).encode(), {"rate": stream.rate})
            self._channels[key] = _Channel(address, number)
        return self._channels[key]

    def _register(self, key: str, schema_name: str, definition: bytes, about: dict[str, str]) -> int:
        if schema_name not in self._schemas:
            number = self._writer.register_schema(schema_name, "jsonschema", definition)
            self._schemas[schema_name] = number
        channel: int = self._writer.register_channel(key, "json", self._schemas[schema_name], about)
        return channel

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Close the file after an error; it is readable to the end of its last chunk."""
        try:
            yield
        except OSError as error:
            with suppress(OSError):  # the buffer cannot be written either
                self._stream.close()
            raise RecordingError(f"cannot continue recording to {self.path}: {error.strerror}") from error


class RecordingWriter:
    """The recording of a run, in one or several files, each readable by itself.

    If writing fails, as on a full disk, an error is logged and further messages are dropped; the run
    continues.

    Args:
        path: the first file; the next are `run-2.mcap` and so on beside `run.mcap`.
        rotation: when another file follows.
        ready: called with the name of each file, once it holds the scenario.

    Raises:
        UsageError: the first file cannot be created.
    """

    def __init__(
        self,
        path: Path,
        run: str,
        scenario: Scenario,
        rotation: Rotation = ONE_FILE,
        ready: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.path, self._run, self._scenario = path, run, scenario
        self._rotation, self._ready = rotation, ready
        self._file: RecordingFile | None = None
        self._open(path)

    def write(self, batch: Sequence[tuple[str, bytes]]) -> None:
        """Record payloads by key, at the simulated time of their ticks."""
        self._do(lambda file: file.write(batch))

    def flush(self) -> None:
        """Make all written messages readable even if this process is killed, and rotate if due."""
        self._do(self._flush)

    def finish(self, result: str | None = None) -> None:
        """Close the recording with the result (a JSON object); later messages are dropped."""
        self._do(lambda file: file.finish(result))
        self._file = None

    def _open(self, path: Path, preceding: str = "") -> None:
        self._file = RecordingFile(path, self._run, self._scenario, preceding)
        self._since = time.monotonic()
        self._ready(str(path))

    def _flush(self, file: RecordingFile) -> None:
        if not self._rotation.due(file.flush(), time.monotonic() - self._since):
            return
        path, self._file = next_free(self.path), None
        try:
            self._open(path, preceding=file.path.name)
        finally:
            file.finish(following="" if self._file is None else path.name)

    def _do(self, what: Callable[[RecordingFile], None]) -> None:
        if self._file is None:
            return
        try:
            what(self._file)
        except (RecordingError, UsageError) as error:
            self._file = None
            LOG.error(f"{error}; the recording ends there, and the run continues")
