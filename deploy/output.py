"""Output of commands: terminal, files and exit statuses. Problems with files are found before the work."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from os.path import realpath
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryFile, mkdtemp
from typing import TYPE_CHECKING

from protocol.errors import UsageError
from protocol.process.signals import STOP, Stopped

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

# After a signal the exit status is 128 plus its number.
EXIT_ARRIVED, EXIT_OTHERWISE, EXIT_INVALID, EXIT_FAULT = 0, 1, 2, 3
_PATIENCE = 2.0  # s before the bar appears
_WIDEST = 1000  # columns of a table


def check_target(target: Path | None, what: str, *others: Path | str | None, text: bool = False) -> None:
    """Raise UsageError if `target` is one of `others`, by whatever name, or forbids `what`, as "record".
    Only `text` may go to standard output or a pipe. Changes nothing; None is nowhere.
    """
    if target is None:
        return
    if any(each is not None and _same(target, each) for each in others):
        raise UsageError(f"cannot {what} to {target}: this command has the file already; name another")
    try:
        if is_standard_output(target) or target.is_fifo():  # opening one would wait for its reader
            if not text:
                raise OSError(0, "standard output and pipes cannot take it")
        elif target.exists():
            target.open("ab").close()
        else:
            TemporaryFile(dir=target.parent).close()
    except OSError as error:
        raise UsageError(
            f"cannot {what} to {target}: {error.strerror}; name a file that can be written"
        ) from error


def _same(one: Path, other: Path | str) -> bool:
    try:
        return one.samefile(other)
    except OSError:  # one of them does not exist
        return realpath(one) == realpath(other)


@contextmanager
def writing(target: Path, what: str) -> Iterator[None]:
    """Context in which `what` (a verb phrase) is written to `target`; a new file is removed after an error
    or a signal. Raises UsageError if writing fails.
    """
    existed = target.exists()
    try:
        yield
    except (OSError, Stopped) as error:
        if not existed:
            with suppress(OSError):
                target.unlink(missing_ok=True)
        if isinstance(error, Stopped):
            raise
        raise UsageError(f"cannot {what} to {target}: {error.strerror or error}") from error


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """A fresh folder (mode 0700) that becomes `target`, in place of an earlier one; none after an error.
    Raises UsageError if it cannot be written.
    """
    with writing(target, "write"):
        target.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(mkdtemp(prefix=f".{target.name}-", dir=target.parent))
        try:
            yield fresh
            if target.exists():
                rmtree(target)
            fresh.rename(target)
        except BaseException:
            rmtree(fresh, ignore_errors=True)
            raise


def is_standard_output(target: Path | None) -> bool:
    """Whether `target` means standard output, which then gets no other text."""
    return str(target) == "-"


def check_text(target: Path | None, *others: Path | str | None) -> None:
    """`check_target` for text."""
    check_target(target, "write", *others, text=True)


def write_text(text: str, target: Path) -> None:
    """Write `text` in UTF-8, whatever the terminal has, into the file `target`, to standard output for '-'.
    Raises UsageError if `target` cannot be written.
    """
    if is_standard_output(target):
        sys.stdout.buffer.write(text.encode())
    else:
        with writing(target, "write"):
            target.write_text(text, encoding="utf-8")


def write_json(document: object, target: Path | None) -> None:
    """`write_text` of `document`; nowhere for None."""
    if target is not None:
        write_text(json.dumps(document, indent=2) + "\n", target)


@contextmanager
def bar(description: str, *, silent: bool = False) -> Iterator[Callable[..., None]]:
    """A progress bar. Call the given function with the share done, 0 to 1, and perhaps a new description;
    nothing is shown if `silent`, or to a file. The function raises Stopped after a signal.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    console = Console(stderr=True)
    hidden = silent or not console.is_terminal  # a file would get an empty line
    progress = Progress(*columns, console=console, transient=True, disable=hidden)
    task = progress.add_task(description, total=1.0)
    began = time.monotonic()

    def tell(done: float, description: str | None = None) -> None:
        STOP.check()
        progress.update(task, completed=done, description=description)
        if time.monotonic() > began + _PATIENCE:
            progress.start()

    try:
        yield tell
    finally:
        progress.stop()


def shown(value: object, form: str) -> str:
    """A value of a table, in this format; "-" for None."""
    return "-" if value is None else format(value, form)


def print_whole(content: RenderableType) -> None:
    """Print tables. A terminal that is too narrow for them wraps their lines, and cuts no number."""
    from rich.console import Console
    from rich.measure import Measurement

    console = Console(soft_wrap=True)
    natural = Measurement.get(console, console.options.update(max_width=_WIDEST), content).maximum
    console.width = max(console.width, natural)
    console.print(content)


def grid(rows: Mapping[str, str]) -> Table:
    """A table of names and texts."""
    from rich.table import Table
    from rich.text import Text

    found = Table.grid(padding=(0, 3))
    for name, text in rows.items():
        found.add_row(Text(name, style="dim"), Text(text))
    return found
