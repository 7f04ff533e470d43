"""A recording that is being written: in as many files as its rotation asks for, while there is room."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from math import inf
from pathlib import Path

from deploy.telemetry.recording.writer import RecordingFile
from protocol.errors import RecordingError, UsageError
from protocol.process.log import LOG
from protocol.scenario.model import Scenario

_BYTES = {"kB": 10**3, "MB": 10**6, "GB": 10**9}
_SECONDS = {"s": 1, "min": 60, "h": 3600, "d": 86400}
_FORM = re.compile(rf"(\d+(?:\.\d+)?)({'|'.join((*_BYTES, *_SECONDS))})")


@dataclass(frozen=True)
class Rotation:
    """A file is followed by another once it has `size` bytes, or is `age` s old by the wall clock."""

    size: float = inf
    age: float = inf

    def due(self, size: int, age: float) -> bool:
        """Whether a file of `size` bytes that is `age` s old is to be followed by another."""
        return size >= self.size or age >= self.age


ONE_FILE = Rotation()


def rotation(given: Sequence[str]) -> Rotation:
    """What a person wrote: `500MB`, `1h`, or one of each.

    Raises:
        UsageError: it is neither.
    """
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


class Parts:
    """What `RecordingFile` does, in one file after the other; each can be read without those before it.

    When the disk is full, or fails, the present file is closed so that what is in it can be read, standard
    error says so, and whatever comes is dropped: a run does not end with its recording.

    Args:
        path: the first file; the next are `run-2.mcap` and so on beside `run.mcap`, or what is free.
        rotation: when another file follows.
        ready: is told the name of each file.

    Raises:
        UsageError: the first file cannot be created.
    """

    def __init__(
        self, path: Path, rotation: Rotation = ONE_FILE, ready: Callable[[str], None] = lambda _: None
    ) -> None:
        self._path, self._rotation, self._ready = path, rotation, ready
        self._begun: tuple[str, Scenario] | None = None
        self._file: RecordingFile | None = None
        self._open(path)

    def begin(self, run: str, scenario: Scenario) -> None:
        """See `RecordingFile.begin`."""
        self._begun = self._begun or (run, scenario)
        self._do(lambda file: file.begin(run, scenario))

    def write(self, batch: Sequence[tuple[str, bytes]]) -> None:
        """See `RecordingFile.write`."""
        self._do(lambda file: file.write(batch))

    def flush(self) -> None:
        """See `RecordingFile.flush`; another file follows if it is time for it."""
        self._do(self._flush)

    def report(self, result: str) -> None:
        """See `RecordingFile.report`."""
        self._do(lambda file: file.report(result))

    def finish(self, result: str | None = None) -> None:
        """See `RecordingFile.finish`; whatever comes after it is dropped."""
        self._do(lambda file: file.finish(result), result)
        self._file = None

    def abandon(self, reason: str) -> None:
        """See `RecordingFile.abandon`; nothing happens if it is finished."""
        self._do(lambda file: file.abandon(reason))
        self._file = None

    def _open(self, path: Path) -> None:
        self._file, self._since = RecordingFile(path), time.monotonic()
        self._ready(str(path))

    def _flush(self, file: RecordingFile) -> None:
        file.flush()
        if self._begun is None or not self._rotation.due(file.size, time.monotonic() - self._since):
            return
        path = next_free(self._path)
        self._open(path)
        file.finish(following=path.name)
        if self._file is not None:
            self._file.begin(*self._begun, preceding=file.path.name)

    def _do(self, what: Callable[[RecordingFile], None], result: str | None = None) -> None:
        """Do something with the present file; if it cannot be written, close it, with `result`, for good."""
        if self._file is None:
            return
        try:
            what(self._file)
        except (RecordingError, UsageError) as error:
            file, self._file = self._file, None
            LOG.error(f"{error}; it ends there, and the run goes on without it")
            try:
                file.abandon(str(error), result)
            except RecordingError as worse:
                LOG.error(f"it is not closed properly either, and can be read as far as it goes: {worse}")


def next_free(path: Path) -> Path:
    """The first of `run-2.mcap`, `run-3.mcap`... that is not there, beside `run.mcap`."""
    parts = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(part for part in parts if not part.exists())
