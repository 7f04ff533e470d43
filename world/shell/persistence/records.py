"""A file of checked records, which is only ever added to; the format of the world's journal.

A magic line, then records: length and CRC-32 of the payload, CRC-32 of these two (three little-endian
uint32), payload. A record that the file ends within is the mark of a death while it was written; any other
damage is told from that by the check of the header.
"""

from __future__ import annotations

import fcntl
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from protocol.errors import JournalError

MAGIC = b"disknav journal 2\n"
_HEADER = struct.Struct("<III")


def record(payload: bytes) -> bytes:
    """What stands in the file for a payload."""
    size, check = len(payload), zlib.crc32(payload)
    return _HEADER.pack(size, check, _check(size, check)) + payload


def write(file: int, content: bytes) -> None:
    """Add all of it; raises OSError."""
    while content:
        content = content[os.write(file, content) :]


def opened(path: Path) -> int:
    """A descriptor that adds to the file, and that nobody else can have at the same time.

    Raises:
        JournalError: there is no such file, or somebody has it.
    """
    try:
        return locked(path)
    except BlockingIOError:
        raise JournalError(f"the journal {path} is in use by another world") from None
    except FileNotFoundError:
        raise JournalError(
            f"the journal {path} is not there: where the run was is not known, so it cannot go on"
        ) from None
    except OSError as error:
        raise JournalError(f"cannot keep a journal in {path}: {error.strerror}") from error


def locked(path: Path) -> int:
    """As `opened`; raises OSError."""
    while True:
        file = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CLOEXEC)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(file), path.stat()):
                return file
        except BaseException:
            os.close(file)
            raise
        os.close(file)  # whoever had it has put another file in its place


def records(path: Path) -> Iterator[tuple[int, bytes, int]]:
    """Where each whole record begins, its payload, and where it ends; there is one at least.

    Raises:
        JournalError: the file is of something else, or damaged; but for its end, which may be missing.
    """
    data = path.read_bytes()
    if not data.startswith(MAGIC):
        raise JournalError(f"{path} is no journal of this version of disknav, and was left as it is")
    start = len(MAGIC)
    while start + _HEADER.size <= len(data):
        size, check, own = _HEADER.unpack_from(data, start)
        if own != _check(size, check):
            damaged(path, start, "the header of a record is not what was written")
        end = start + _HEADER.size + size
        if end > len(data):
            break
        payload = data[start + _HEADER.size : end]
        if zlib.crc32(payload) != check:
            damaged(path, start, "a record is not what was written")
        yield start, payload, end
        start = end
    if start == len(MAGIC):
        damaged(path, start, "there is no head")


def damaged(path: Path, place: int, what: str) -> NoReturn:
    """Refuse the file."""
    raise JournalError(f"the journal {path} is damaged at byte {place}: {what}; the run cannot go on from it")


def _check(size: int, check: int) -> int:
    return zlib.crc32(struct.pack("<II", size, check))
