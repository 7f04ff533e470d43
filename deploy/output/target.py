"""Files that a command is asked to write: what would fail is found out beforehand, what fails is one line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from protocol.errors import UsageError


def check_target(target: Path, what: str) -> None:
    """Make sure that `what` (a verb phrase, such as "write JSON") can be written to `target`.

    What is there already is left as it is, and nothing is left where nothing was.

    Raises:
        UsageError: it cannot.
    """
    if target.is_fifo():  # opening one would wait for its reader
        return
    try:
        if target.exists():
            target.open("ab").close()
        else:
            TemporaryFile(dir=target.parent).close()
    except OSError as error:
        raise UsageError(
            f"cannot {what} to {target}: {error.strerror}; name a file that can be written"
        ) from error


@contextmanager
def writing(target: Path, what: str) -> Iterator[None]:
    """Inside, `what` (a verb phrase) is written to `target`; no half of it is left where nothing was.

    Raises:
        UsageError: it cannot be written: the disk is full, or may only be read.
    """
    existed = target.exists()
    try:
        yield
    except OSError as error:
        if not existed:
            with suppress(OSError):
                target.unlink(missing_ok=True)
        raise UsageError(f"cannot {what} to {target}: {error.strerror or error}") from error
