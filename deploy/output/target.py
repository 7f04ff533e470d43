"""Files that a command is asked to write: found out beforehand what would fail after the work."""

from __future__ import annotations

from pathlib import Path

from protocol.errors import UsageError


def check_target(target: Path, what: str) -> None:
    """Make sure that `what` (a verb phrase, such as "write JSON") can be written to `target`.

    What is there already is left as it is, and nothing is left where nothing was.

    Raises:
        UsageError: it cannot.
    """
    if target.is_fifo():  # opening one would wait for its reader
        return
    existed = target.exists()
    try:
        target.open("ab").close()
    except OSError as error:
        raise UsageError(
            f"cannot {what} to {target}: {error.strerror}; name a file that can be written"
        ) from error
    if not existed:
        target.unlink()
