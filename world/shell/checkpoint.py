"""The checkpoint: a small file from which a successor continues the run of a world that has died.

It contains `world.world.Past`: positions of disks, robots of the fleet, operations, the record of the run. It
is written before any change is published, once a tick and with each reply, and so is never older than the
knowledge of robots, operators or the launcher.

A successor does not take over lives. It draws its own epoch, under which all earlier messages are refused,
and founds the ledger on the positions of the disks, which are all static. A robot has no life there before it
joins again. In a simulation no disk has moved meanwhile. An external base may move on while its lease lasts:
the bound of its position covers this, and its next life begins only afterwards.

The file has two places for a state, written in turn, so that one of them is complete at every moment; at
first one has an empty state. Damage to the newest looks like a write that the death of the world cut short:
the run goes on from the state before. The file survives the death of this process, but is not forced to the
disk: one from before the last start of the machine is refused, if the system identifies its starts.
"""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import stat
import struct
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from io import FileIO
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Final, NoReturn

import msgspec

from protocol.codec import DAMAGED
from protocol.errors import CheckpointError
from protocol.messages import Count, Epoch, Id
from protocol.scenario.model import Scenario
from world.coordinator.records import Fate, Life
from world.past import Past

_MAGIC: Final = b"disknav checkpoint 1\n"
_STATE: Final = 1 << 20  # bytes of each of the two places for a state; unwritten ones use no disk space
_FRAME: Final = struct.Struct("<QII")  # number and size of a state; CRC-32 of these, 0, and the state
_KEPT: Final = 16  # remembered earlier processes of a robot
_BOOT: Final = Path("/proc/sys/kernel/random/boot_id")


class Processes(msgspec.Struct):
    """Processes that were admitted, by the names that they gave themselves, and which never come back.

    One that the scenario has ended may live on for a while, and so may one whose robot was removed: it has no
    other life, of its robot or of another with the same id. The fate of a robot's newest process is that of
    its newest life.
    """

    newest: dict[Id, str] = {}  # newest process of each robot
    over: dict[Id, dict[str, Fate]] = {}  # earlier ones, in order
    expected: dict[Id, Count] = {}  # number of next lives of each robot that the worlds have awaited

    def admit(self, robot: int, session: str, before: Fate) -> None:
        """Note the newest process of a robot; `before` is the fate of the one before it."""
        if before:
            fates = self.over.setdefault(robot, {})
            fates[self.newest.get(robot, "")] = before
            if len(fates) > _KEPT:
                del fates[next(iter(fates))]
        self.newest[robot] = session

    def fate(self, robot: int, session: str, lives: Mapping[int, Life]) -> Fate:
        """The fate of a process; "" if it may be the robot's next life."""
        life = lives.get(robot)
        if life is not None and session == self.newest.get(robot):
            return life.fate
        return self.over.get(robot, {}).get(session, "")


class SavedRun(msgspec.Struct, frozen=True):
    """State of a run for a successor of its world."""

    epochs: tuple[Epoch, ...] = ()  # of the coordinators so far
    began: float = 0.0  # s, wall clock at the beginning of the first tick
    processes: Processes = msgspec.field(default_factory=Processes)
    past: Past = Past()


class _State(msgspec.Struct, frozen=True):
    """Content of the file."""

    run: str
    scenario: str  # digest of it
    boot: str  # identifies the machine's last start; empty if the system does not
    progress: SavedRun


_encoder = msgspec.msgpack.Encoder()
_decoder = msgspec.msgpack.Decoder(_State)


class Checkpoint:
    """The checkpoint of one world, locked by this process until it is closed.

    Args:
        path: the file; `create` makes it.
        run, scenario: those that it must belong to.
        warn: receives a warning if it cannot be written any longer.

    Raises:
        CheckpointError: the file is missing, damaged, in use, or of another run; it is left unchanged.
    """

    def __init__(
        self, path: Path, run: str, scenario: Scenario, warn: Callable[[str], None] = lambda _: None
    ) -> None:
        self.path = path
        self.kept = True  # whether it can be written; otherwise it is emptied, and no world continues from it
        self._of, self._warn, self._buffer = (run, _digest(scenario), boot()), warn, bytearray()
        try:
            self._file = FileIO(os.open(path, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW), "r+")
        except FileNotFoundError:
            _refuse(path, "does not exist, so the run cannot be continued")
        except OSError as error:
            _refuse(path, f"cannot be kept: {error.strerror}")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._opened = os.fstat(self._file.fileno())
            if not os.path.samestat(self._opened, path.stat()):
                raise BlockingIOError  # removed, and perhaps created anew, since it was opened
            self._number, state = _newest(path, self._file.fileno())
            self.progress = SavedRun() if state is None else self._checked(state)  # of earlier worlds
        except BaseException as error:
            self._file.close()
            if isinstance(error, BlockingIOError | FileNotFoundError):
                _refuse(path, "is in use by another world")
            if isinstance(error, OSError):
                _refuse(path, f"cannot be kept: {error.strerror}")
            if isinstance(error, CheckpointError):
                raise CheckpointError(f"{error}; name another file to begin anew") from None
            raise

    @staticmethod
    def create(path: Path) -> None:
        """Create the whole file for a run that has not begun; CheckpointError if it cannot, or exists."""
        try:
            with NamedTemporaryFile(dir=path.parent, prefix=f"{path.name}.") as file:
                file.write(_MAGIC)
                file.truncate(_place(2))
                file.seek(_place(1))
                file.write(_frame(1, bytearray(_FRAME.size)))
                file.flush()
                os.link(file.name, path)  # unlike a renamed file, it replaces none
        except OSError as error:
            _refuse(path, f"cannot be kept: {error.strerror}")

    def write(self, progress: SavedRun) -> None:
        """Replace the older of the two states; afterwards a successor would continue from this one.

        Raises CheckpointError if it can neither be written nor emptied, and would be outdated.
        """
        if not self.kept:
            return
        self._number += 1
        content = self._buffer  # large, and written in each tick
        _encoder.encode_into(_State(*self._of, progress), content, _FRAME.size)
        _frame(self._number, content)
        try:
            if not os.fstat(self._file.fileno()).st_nlink:
                raise OSError(0, "it was deleted")
            if len(content) > _STATE:
                raise OSError(0, "the state is too large")
            if os.pwrite(self._file.fileno(), content, _place(self._number % 2)) < len(content):
                raise OSError(0, "the disk is full")
        except OSError as error:
            self._abandon(error)

    def remove(self) -> None:
        """Remove the file at the end of the run, and close; raises CheckpointError if it remains."""
        try:
            with suppress(FileNotFoundError):
                if os.path.samestat(self._opened, self.path.lstat()):  # else it is another world's
                    self.path.unlink()
        except OSError as error:
            _refuse(self.path, f"cannot be removed: {error.strerror}")
        finally:
            self.close()

    def close(self) -> None:
        """Release the file for the next process."""
        self.kept = False
        self._file.close()

    def _abandon(self, why: OSError) -> None:
        """Empty the file, whatever its name is by now: no world may go on from an older state."""
        self.kept = False
        try:
            os.ftruncate(self._file.fileno(), 0)
        except OSError as error:
            if error.errno != errno.ESTALE:  # else another host has deleted it
                _refuse(self.path, f"can be neither written ({why.strerror}) nor emptied: {error.strerror}")
        self._warn(
            f"cannot keep the checkpoint {self.path}: {why.strerror}; "
            f"the run goes on, but the next death of this world ends it"
        )

    def _checked(self, state: _State) -> SavedRun:
        run, scenario, start = self._of
        if state.run != run:
            _refuse(self.path, f"is of run {state.run!r}, not of {run!r}")
        if state.scenario != scenario:
            _refuse(self.path, "is of another scenario than the one that is to be run")
        if state.boot != start:
            _refuse(self.path, "is from before this machine was last started, and may be behind")
        return state.progress


@cache
def boot() -> str:
    """The system's identifier of its last start; empty if it has none."""
    return _BOOT.read_text().strip() if _BOOT.exists() else ""


def _digest(scenario: Scenario) -> str:
    return hashlib.sha256(_encoder.encode(scenario)).hexdigest()


def _refuse(path: Path, why: str) -> NoReturn:
    raise CheckpointError(f"the checkpoint {path} {why}")


def _place(index: int) -> int:
    return len(_MAGIC) + index * _STATE


def _frame(number: int, content: bytearray) -> bytearray:
    """`content`, with a frame before the state in it."""
    size = len(content) - _FRAME.size
    _FRAME.pack_into(content, 0, number, size, 0)
    _FRAME.pack_into(content, 0, number, size, zlib.crc32(content))
    return content


def _whole(content: bytes) -> tuple[int, bytes] | None:
    """Number and payload at a place; None if they are damaged."""
    number, size, _ = _FRAME.unpack_from(content)
    framed = bytearray(content[: _FRAME.size + size])
    _frame(number, framed)
    return (number, content[_FRAME.size :][:size]) if content.startswith(framed) else None


def _newest(path: Path, opened: int) -> tuple[int, _State | None]:
    """Number of the newest state, and the state; None if no world has written one."""
    if not stat.S_ISREG(os.fstat(opened).st_mode):
        _refuse(path, "is not a regular file")
    with open(opened, "rb", closefd=False) as file:
        content = file.read(_place(2) + 1)
    if not content:
        _refuse(path, "is empty: a world could not write it, so the run is over")
    if not content.startswith(_MAGIC):
        _refuse(path, "is of another version of disknav, or no checkpoint")
    if len(content) != _place(2):
        _refuse(path, "is damaged: it was cut short, or is too long")
    states = [each for index in (0, 1) if (each := _whole(content[_place(index) :][:_STATE]))]
    if not states:
        _refuse(path, "is damaged: neither of its two states is whole")
    number, payload = max(states)
    try:
        return number, _decoder.decode(payload) if payload else None
    except DAMAGED as error:
        _refuse(path, f"is of another version of disknav, or damaged: {error}")
