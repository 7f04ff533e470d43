"""The world's checkpoint: a file of all that it was told in the present run, in order.

What is noted is written before anything that follows from it is announced; only commands, and attempts to
open a tick or to join, wait for what comes after them: they can be made again. So each tick is one write to
the system, which keeps it when this process is killed. It is not forced to the disk: a journal from before
the machine was last started is refused.

The first record (`world.shell.persistence.records`) is a `Head`, all others are lists of entries; msgpack.
A torn last one is cut off. A snapshot begins a new file in the place of the old one: it is its first entry.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import msgspec

from protocol.codec import DAMAGED
from protocol.errors import JournalError
from protocol.messages import Command, Epoch, Id
from protocol.scenario.model import Scenario
from world.coordinator.inputs import Input, Opened
from world.shell.persistence import records
from world.shell.persistence.snapshot import Snapshot
from world.shell.run import drawn_epoch

_BOOT = Path("/proc/sys/kernel/random/boot_id")


class Head(msgspec.Struct, frozen=True):
    """What the file is a journal of."""

    run: str
    scenario: str  # digest of it
    boot: str  # names the time since the machine was started; empty where the system has no such name
    epoch: Epoch  # of the coordinator; a world that goes on from the journal is the same one


class Seated(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="seat"):
    """The process that calls itself `session` is to be the robot's next life."""

    robot: Id
    session: str


class Began(msgspec.Struct, frozen=True, array_like=True, gc=False, tag="began"):
    """The first tick began."""

    at: float  # s, wall clock


Entry = Input | Seated | Began | Snapshot
_WAITING = (Command, Opened, Seated)  # for what follows: nothing is announced until it does

_encoder = msgspec.msgpack.Encoder()
_head = msgspec.msgpack.Decoder(Head)
_entries = msgspec.msgpack.Decoder(list[Entry])


class Journal:
    """The journal of one world, held by this process alone until it is closed.

    Args:
        path: the file; `create` makes it.
        run, scenario: what it must be a journal of.
        say: is told if the journal cannot be kept any longer.

    Attributes:
        head: of the run.
        past: what was noted before this process opened the file.
        kept: whether it can be written; once it cannot the file is removed, so that nobody goes on from it.

    Raises:
        JournalError: the file is not there, is damaged, is in use, or is of something else. Nothing was
            changed then.
    """

    def __init__(
        self, path: Path, run: str, scenario: Scenario, say: Callable[[str], None] = lambda _: None
    ) -> None:
        self.path, self.kept = path, True
        self._say = say
        self._aside: list[Entry] = []
        self._newest: Entry | None = None
        self._file = records.opened(path)
        try:
            (start, payload, _), *others = found = list(records.records(path))
            self.head = _checked(path, start, payload, Head(run, digest(scenario), _boot(), 0))
            self.past = [entry for start, payload, _ in others for entry in _decoded(path, start, payload)]
            os.ftruncate(self._file, found[-1][-1])
        except BaseException:
            os.close(self._file)
            raise

    @staticmethod
    def create(path: Path, run: str, scenario: Scenario) -> None:
        """Make the file for a run that has not begun.

        Raises:
            JournalError: it cannot be written, or is there already.
        """
        try:
            with path.open("xb") as file:
                file.write(_beginning(Head(run, digest(scenario), _boot(), drawn_epoch())))
        except OSError as error:
            raise JournalError(f"cannot keep a journal in {path}: {error.strerror}") from error

    def note(self, entry: Entry) -> None:
        """Add an entry. When this returns it is written, unless it is one that waits for the next.

        Raises:
            JournalError: it cannot be written, and the file cannot be removed either: going on would leave
                a checkpoint that is too old to go on from.
        """
        if not self.kept or (isinstance(entry, Opened) and isinstance(self._newest, Opened)):
            return  # to try to open a tick again, with nothing in between, changes nothing
        self._newest = entry
        self._aside.append(entry)
        if not isinstance(entry, _WAITING):
            entries, self._aside = self._aside, []
            try:
                records.write(self._file, records.record(_encoder.encode(entries)))
            except OSError as error:
                self._abandon(error)

    def compact(self, snapshot: Snapshot) -> None:
        """Begin anew with a snapshot of the run, in place of all that led to it; where that cannot be
        written, the journal goes on as it was."""
        if self.kept:
            try:
                self._renew(snapshot)
            except OSError as error:
                self._say(f"no snapshot in the journal {self.path}: {error.strerror}; it goes on, and grows")

    def _renew(self, snapshot: Snapshot) -> None:
        """Raises OSError if that cannot be; nothing has changed then."""
        following = self._following
        try:
            following.write_bytes(_beginning(self.head, snapshot))
            file = records.locked(following)
            try:
                following.replace(self.path)
            except OSError:
                os.close(file)
                raise
        except OSError:
            with suppress(OSError):
                following.unlink()
            raise
        os.close(self._file)
        self._file, self.past = file, []
        self._aside, self._newest = [], None

    @property
    def _following(self) -> Path:
        """Where a new file is written that is to take the old one's place."""
        return self.path.with_name(f"{self.path.name}.next")

    def remove(self) -> None:
        """The run is over, or cannot be gone on with: nothing is left of it."""
        if self.kept:
            for path in (self.path, self._following):  # a world may have died in between
                path.unlink(missing_ok=True)
            self.close()

    def close(self) -> None:
        """Leave the file to the next process."""
        if self.kept:
            self.kept = False
            os.close(self._file)

    def _abandon(self, error: OSError) -> None:
        try:
            self.remove()
        except OSError as worse:
            raise JournalError(
                f"cannot write the journal {self.path} ({error.strerror}), nor remove it ({worse.strerror})"
            ) from error
        self._say(
            f"cannot keep the journal {self.path}: {error.strerror}; "
            f"the run goes on, but the next death of this world ends it"
        )


def digest(scenario: Scenario) -> str:
    """Of everything that the scenario says."""
    return hashlib.sha256(_encoder.encode(scenario)).hexdigest()


def _boot() -> str:
    return _BOOT.read_text().strip() if _BOOT.exists() else ""


def _beginning(head: Head, *entries: Entry) -> bytes:
    payloads = [_encoder.encode(head), *(_encoder.encode([entry]) for entry in entries)]
    return records.MAGIC + b"".join(map(records.record, payloads))


def _decoded(path: Path, place: int, payload: bytes) -> list[Entry]:
    try:
        return _entries.decode(payload)
    except DAMAGED as error:
        records.damaged(path, place, str(error))


def _checked(path: Path, place: int, payload: bytes, wanted: Head) -> Head:
    try:
        head = _head.decode(payload)
    except DAMAGED as error:
        records.damaged(path, place, str(error))
    other = ""
    if head.run != wanted.run:
        other = f"of run {head.run!r}, not of {wanted.run!r}"
    elif head.scenario != wanted.scenario:
        other = "of another scenario than the one that is to be run"
    elif head.boot != wanted.boot:
        other = "from before this machine was last started, and may lack the newest ticks"
    if other:
        raise JournalError(f"the journal {path} is {other}; it was left as it is")
    return head
