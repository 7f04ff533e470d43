"""What a command leaves on the terminal, in files and as exit status.

What would fail when a file is written is found out beforehand; what fails is one line.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from protocol.errors import UsageError
from protocol.process.signals import STOP

# A signal that ends a command says 128 and its number.
EXIT_ARRIVED, EXIT_OTHERWISE, EXIT_INVALID, EXIT_FAULT = 0, 1, 2, 3
_PATIENCE = 2.0  # s without a bar


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


_STANDARD_OUTPUT = "-"
_JSON = "write JSON"


def is_standard_output(target: Path | None) -> bool:
    """Whether `target` asks for standard output, which then takes nothing else."""
    return str(target) == _STANDARD_OUTPUT


def check_json(target: Path | None) -> None:
    """Find out before the work what would fail after it.

    Raises:
        UsageError: `target` cannot be written.
    """
    if target is not None and not is_standard_output(target):
        check_target(target, _JSON)


def write_json(document: object, target: Path | None) -> None:
    """Write `document` into the file `target`, to standard output for '-', nowhere for None.

    Raises:
        UsageError: `target` cannot be written.
    """
    if target is None:
        return
    text = json.dumps(document, indent=2) + "\n"
    if is_standard_output(target):
        sys.stdout.write(text)
    else:
        with writing(target, _JSON):
            target.write_text(text, encoding="utf-8")


@contextmanager
def bar(description: str, *, silent: bool = False) -> Iterator[Callable[[float], None]]:
    """Inside, tell the function that is given how much is done, from 0 to 1; nothing is shown if `silent`.

    It raises Stopped if a signal asks this process to end.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    progress = Progress(*columns, console=Console(stderr=True), transient=True, disable=silent)
    task = progress.add_task(description, total=1.0)
    began = time.monotonic()

    def tell(done: float) -> None:
        STOP.check()
        progress.update(task, completed=done)
        if time.monotonic() > began + _PATIENCE:
            progress.start()

    try:
        yield tell
    finally:
        progress.stop()
