"""What MCAP files hold, whole or cut: a recording and the files that continue it, read as one."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import accumulate, count
from pathlib import Path
from typing import NamedTuple

import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from protocol.errors import RecordingError, UsageError

_DAMAGE = (
    McapError, ValueError, RuntimeError, OverflowError, struct.error, zstandard.ZstdError, MemoryError,
)  # fmt: skip
_NEVER = 1 << 64


class Recorded(NamedTuple):
    """One message: under which key it was published, its log time, ns, and its JSON."""

    key: str
    time: int
    data: bytes


@dataclass
class _File:
    """One file, all of whose messages are in chunks.

    Attributes:
        firsts: smallest log time of each chunk, ns.
        cut: the file has no proper end, or is damaged: all before that is here.
    """

    path: Path
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    firsts: list[int] = field(default_factory=list)
    cut: bool = True

    @property
    def run(self) -> str:
        return self.metadata.get("run", {}).get("name", "")

    def records(self) -> Iterator[McapRecord]:
        """Those up to the cut, chunks in one piece."""
        with self.path.open("rb") as file:
            try:
                size = self.path.stat().st_size
                yield from StreamReader(file, emit_chunks=True, record_size_limit=size).records
            except _DAMAGE:
                return
            self.cut = False

    def messages(self, progress: Callable[[float], None]) -> Iterator[Recorded]:
        """In the order of their log time, within one time as they were written.

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
                    keys[record.id] = record.topic  # of the run; the others draw it
                elif isinstance(record, Message) and (key := keys.get(record.channel_id)):
                    heappush(
                        waiting, (record.log_time, next(order), Recorded(key, record.log_time, record.data))
                    )
            while waiting and waiting[0][0] <= later:
                yield heappop(waiting)[2]
            progress(done / len(self.firsts))
        while waiting:  # what follows is damaged
            yield heappop(waiting)[2]


def _look_through(path: Path) -> _File:
    """Find the metadata and the chunks of a file, without its messages."""
    found = _File(path)
    try:
        with path.open("rb") as file:
            magic = file.read(len(MCAP0_MAGIC))
        if not magic:
            raise RecordingError(f"{path} is empty: nothing was recorded")
        if magic != MCAP0_MAGIC:
            raise RecordingError(f"{path} is not a recording: name a file that `disknav run --record` wrote")
        for record in found.records():
            if isinstance(record, Metadata):
                found.metadata[record.name] = record.metadata
            elif isinstance(record, Chunk):
                found.firsts.append(record.message_start_time)
    except OSError as error:
        raise UsageError(f"cannot read {path}: {error.strerror}") from error
    return found


class Contents:
    """A file and all that continue it, looked through without reading their messages.

    Attributes:
        path: of the first.
        metadata: of the first what the run is, of the last how it ended.

    Raises:
        UsageError: the first file cannot be opened.
        RecordingError: the first is not an MCAP file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._files, self._complete = [_look_through(path)], True
        while following := self._files[-1].metadata.get("recorder", {}).get("following"):
            path = path.with_name(Path(following).name)
            if not self._continued(path):
                self._complete = False
                break
        first, self.metadata = self._files[0].metadata, dict(self._files[-1].metadata)
        self.metadata.update({name: first[name] for name in ("run", "scenario") if name in first})

    def _continued(self, path: Path) -> bool:
        """Whether `path` continues the files so far; another recording may have taken its name."""
        try:
            file = _look_through(path)
        except (UsageError, RecordingError):
            return False
        if file.run != self._files[0].run or path in [each.path for each in self._files]:
            return False
        self._files.append(file)
        return True

    @property
    def cut(self) -> bool:
        """Whether a file has no proper end or is damaged as far as it was read, or the next is missing."""
        return not self._complete or any(file.cut for file in self._files)

    def messages(self, progress: Callable[[float], None] = lambda _: None) -> Iterator[Recorded]:
        """Those of the run, without the drawn scene: in the order of log time within each file."""
        for done, file in enumerate(self._files):

            def tell(share: float, done: int = done) -> None:
                progress((done + share) / len(self._files))

            yield from file.messages(tell)
