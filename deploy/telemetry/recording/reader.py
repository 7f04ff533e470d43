"""Reading recordings: one MCAP file, or several that continue each other, complete or cut.

Messages are read from the file in each loop. Only the positions stay in memory, about 20 bytes per robot and
tick.
"""

from __future__ import annotations

import json
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import accumulate, count
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, McapRecord, Metadata
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

from deploy.telemetry.recording.form import from_json
from deploy.telemetry.recording.trajectory import CompactTruth, Trajectory, columns_of
from protocol.codec import DAMAGED
from protocol.errors import KeyGrammarError, RecordingError, ScenarioError, UsageError
from protocol.keys import STREAMS, parse
from protocol.messages import Count, Message, Truth, Vector
from protocol.scenario.file import validated
from protocol.scenario.model import Scenario
from world.world import WorldCore

_DAMAGE = (
    McapError, ValueError, RuntimeError, OverflowError, struct.error, zstandard.ZstdError, MemoryError,
)  # fmt: skip
_NEVER = 1 << 64
Progress = Callable[[float], None]  # receives the share that is done, 0 to 1


class Recorded(NamedTuple):
    """One message: key, log time, ns, and JSON."""

    key: str
    time: int
    data: bytes


@dataclass
class _RecordedFile:
    """One file, all of whose messages are in chunks; all before a cut is available."""

    path: Path
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    firsts: list[int] = field(default_factory=list)  # smallest log time of each chunk, ns
    cut: bool = True  # the file has no proper end, goes on after it, or is damaged

    @property
    def run(self) -> str:
        return self.metadata.get("run", {}).get("name", "")

    def records(self) -> Iterator[McapRecord]:
        """Records up to the cut, with whole chunks."""
        with self.path.open("rb") as file:
            try:
                size = self.path.stat().st_size
                yield from StreamReader(file, emit_chunks=True, record_size_limit=size).records
            except _DAMAGE:
                return
            self.cut = bool(file.read(1))

    def messages(self, progress: Progress) -> Iterator[Recorded]:
        """Messages by log time, of equal times as written.

        A message is held back until no later chunk can have an earlier one.
        """
        waiting: list[tuple[int, int, Recorded]] = []
        keys: dict[int, str] = {}
        order = count()
        laters = [*accumulate(reversed(self.firsts), min, initial=_NEVER)][-2::-1]
        chunks = (record for record in self.records() if isinstance(record, Chunk))
        for done, (chunk, later) in enumerate(zip(chunks, laters, strict=False), 1):
            try:
                found = breakup_chunk(chunk, validate_crc=True)
            except _DAMAGE:
                self.cut, self.firsts = True, self.firsts[: done - 1]
                break
            for record in found:
                if isinstance(record, Channel) and not record.topic.startswith("/"):
                    keys[record.id] = record.topic  # topics with "/" are the scene's
                elif isinstance(record, McapMessage) and (key := keys.get(record.channel_id)):
                    heappush(
                        waiting, (record.log_time, next(order), Recorded(key, record.log_time, record.data))
                    )
            while waiting and waiting[0][0] <= later:
                yield heappop(waiting)[2]
            progress(done / len(self.firsts))
        while waiting:  # the rest of the file is damaged
            yield heappop(waiting)[2]


def _look_through(path: Path) -> _RecordedFile:
    found = _RecordedFile(path)
    try:
        with path.open("rb") as file:
            magic = file.read(len(MCAP0_MAGIC))
        if not magic:
            raise RecordingError(f"{path} is empty: nothing was recorded")
        if magic != MCAP0_MAGIC:
            raise UsageError(f"{path} is not a recording: name a file that `disknav run --record` wrote")
        for record in found.records():
            if isinstance(record, Metadata):
                found.metadata[record.name] = record.metadata
            elif isinstance(record, Chunk):
                found.firsts.append(record.message_start_time)
            elif isinstance(record, McapMessage):
                raise UsageError(f"{path} has messages outside of chunks: name a file that disknav wrote")
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from error
    return found


class Contents:
    """A file and those that continue it, without their messages; its metadata are run and scenario of the
    first file, and the result of the last.

    Raises:
        UsageError: the first file cannot be opened, or is of another kind.
        RecordingError: it is empty.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._files, self._complete = [_look_through(path)], True
        while following := self._files[-1].metadata.get("recorder", {}).get("following"):
            if not self._continued(following):
                self._complete = False
                break
        first, self.metadata = self._files[0].metadata, dict(self._files[-1].metadata)
        self.metadata.update({name: first[name] for name in ("run", "scenario") if name in first})

    def _continued(self, name: str) -> bool:
        """Whether the file of this name continues those so far; it may belong to another recording."""
        try:
            path = self.path.with_name(Path(name).name)
            file = _look_through(path)
        except (UsageError, RecordingError, ValueError):
            return False
        if file.run != self._files[0].run or path in [each.path for each in self._files]:
            return False
        self._files.append(file)
        return True

    @property
    def cut(self) -> bool:
        """Whether a file has no proper end, is damaged as far as read, or the next file is missing."""
        return not self._complete or any(file.cut for file in self._files)

    def messages(self, progress: Progress = lambda _: None) -> Iterator[Recorded]:
        """Messages of the run, by log time within each file."""
        for done, file in enumerate(self._files):

            def tell(share: float, done: int = done) -> None:
                progress((done + share) / len(self._files))

            yield from file.messages(tell)


_M = TypeVar("_M", bound=Message)


class _Judged(msgspec.Struct):
    """What readers use of a result."""

    verdict: str
    ticks: Count = 0
    trajectory_sha256: str | None = None
    positions: dict[int, Vector] | None = None
    worlds: tuple[Count, ...] = ()


class Entry(NamedTuple):
    """One recorded message: simulated time, s, key and message."""

    time: float
    key: str
    message: Message


class Entries:
    """All messages by time and, within one tick, by arrival; every loop reads the file again.
    Loops raise RecordingError if another version wrote a message.
    """

    def __init__(self, found: Contents, keep: Callable[[Entry], bool] = lambda _: True) -> None:
        self._found, self._keep = found, keep

    def __iter__(self) -> Iterator[Entry]:
        return self.of(Message)

    def of(self, *kinds: type[Message]) -> Iterator[Entry]:
        """Messages of these kinds; no others are decoded."""
        wanted: dict[str, type[Message] | None] = {}  # by key
        for key, time, data in self._found.messages():
            with _by_this_version(self._found.path):
                if key not in wanted:
                    kind = STREAMS[parse(key).stream].message
                    wanted[key] = kind if issubclass(kind, kinds) else None
                if (kept := wanted[key]) is None:
                    continue
                message = from_json(kept, data)
            entry = Entry(time / 1e9, key, message)
            if self._keep(entry):
                yield entry

    def where(self, keep: Callable[[Entry], bool]) -> Entries:
        """Entries for which `keep` is true."""
        return Entries(self._found, lambda entry: self._keep(entry) and keep(entry))


@dataclass(frozen=True, eq=False)
class Recording:
    """A recorded run.

    Attributes:
        run: name of the run.
        result: the result, as of `disknav run --json` or of the world; None if the recording ended earlier.
        entries: all recorded messages in order, each with `time` (simulated s), `key` and `message`;
            every iteration reads the file again.
        counts: number of messages by key.
        trajectory: all ticks whose truth was recorded; a busy network may have dropped some.
        preceding: name of the file that this one continues; empty for the first.
        cut: a file was cut short, is damaged or lacks its next, or the disk was full; the rest is available.
    """

    path: Path
    run: str
    scenario: Scenario
    result: dict[str, Any] | None
    entries: Entries
    counts: Counter[str]
    trajectory: Trajectory
    preceding: str
    cut: bool

    def messages(self, kind: type[_M]) -> Iterator[_M]:
        """All messages of a kind, in order."""
        for entry in self.entries.of(kind):
            assert isinstance(entry.message, kind)
            yield entry.message

    def columns(self, stream: str) -> dict[str, NDArray[Any]]:
        """One row per message of `stream` ("command", "state", ...), a column for `time` (s) and each field.

        A position or velocity makes two columns, such as `position_x` and `position_y`, NaN where missing;
        other values stay objects. docs/streams.md describes the fields.

        Raises:
            UsageError: no such stream.
        """
        if stream not in STREAMS:
            raise UsageError(f"no stream {stream!r}; there are {', '.join(STREAMS)}")
        entries = list(self.entries.of(STREAMS[stream].message))
        times = np.array([entry.time for entry in entries])
        return {"time": times, **columns_of(STREAMS[stream].message, [entry.message for entry in entries])}


def read(path: Path | str, progress: Progress = lambda _: None) -> Recording:
    """Read a recording of `run` or of the command, complete or cut, with the files that follow it; `progress`
    receives the share done.

    Raises:
        UsageError: there is no such file, or disknav did not write it.
        RecordingError: it is damaged, or of another version.
    """
    path = Path(path)
    found = Contents(path)
    scenario, about = _scenario(path, found), found.metadata.get("run", {})
    run, preceding = about.get("name", ""), about.get("preceding", "")
    result = found.metadata.get("result")
    with _by_this_version(path):
        counts, trajectory = _looked_through(found, scenario, not preceding, progress)
        report = None if result is None else json.loads(result["json"])
        msgspec.convert(report, _Judged | None, strict=False)
    recorder = found.metadata.get("recorder")
    cut = found.cut or recorder is None
    return Recording(path, run, scenario, report, Entries(found), counts, trajectory, preceding, cut)


@contextmanager
def _by_this_version(path: Path) -> Iterator[None]:
    try:
        yield
    except (KeyError, ValueError, KeyGrammarError, RecursionError) as error:
        reason = f"{path} was written by another version, with other fields in a message: {error}"
        raise RecordingError(f"{reason}; read it with the version that wrote it") from error


def _scenario(path: Path, found: Contents) -> Scenario:
    try:
        scenario = validated(msgspec.json.decode(found.metadata["scenario"]["json"], type=Scenario))
        _ = scenario.k  # a number in every recording
        return scenario
    except KeyError:
        if found.cut:
            raise RecordingError(f"{path} was cut before the run began; nothing was recorded") from None
        raise UsageError(f"{path} holds no scenario: disknav did not write it") from None
    except (*DAMAGED, ScenarioError) as error:
        raise RecordingError(f"{path}: its scenario cannot be read by this version: {error}") from error


def _looked_through(
    found: Contents, scenario: Scenario, whole: bool, progress: Progress
) -> tuple[Counter[str], Trajectory]:
    counts: Counter[str] = Counter()
    places: dict[int, CompactTruth] = {}
    robots: tuple[int, ...] = ()
    for key, _, data in found.messages(progress):
        counts[key] += 1
        if key.endswith("/world/truth"):
            truth = from_json(Truth, data)
            assert isinstance(truth, Truth)
            robots = robots if truth.robots == robots else truth.robots  # share equal tuples
            places[truth.tick] = CompactTruth.of(truth)._replace(robots=robots)
    if whole or not places:
        places.setdefault(0, CompactTruth.of(WorldCore(scenario).truth))  # the starts
    return counts, Trajectory.of((places[tick] for tick in sorted(places)), scenario.time.step)
