"""Logging: text on the terminal and, on request, lines of JSON in files; and the titles of processes.

Modules log to `LOG`: `warning` and `error` for the operator, `info` for the files alone.
"""

from __future__ import annotations

import logging
import sys
from datetime import UTC, datetime
from logging.handlers import WatchedFileHandler
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from setproctitle import setproctitle, setthreadtitle

from protocol.errors import UsageError

LOG = logging.getLogger("disknav")
LAUNCHER = "launcher"
LogLevel = Literal["info", "warning", "error"]
Name = Annotated[str, msgspec.Meta(max_length=100, pattern=r"^[\w.-]*$")]


class Speaker(msgspec.Struct, frozen=True):
    """The process that logs."""

    run: Name = ""
    host: Name = ""  # of a fleet on several hosts; empty on the launcher's
    role: Name = ""  # `robot`, `world`, `router`, `recorder` or `launcher`
    robot: int | None = None  # its number, if it is a robot

    @property
    def label(self) -> str:
        """Prefix of its lines on the terminal."""
        role = "disknav" if self.role == LAUNCHER else self.role
        named = role if self.robot is None else f"{role} {self.robot}"
        return ": ".join(filter(None, (self.host, named)))


class LogLine(Speaker, frozen=True, kw_only=True):
    """One line of a file: the process, its text, and the time by its host's clock."""

    time: Annotated[datetime, msgspec.Meta(tz=True)]
    level: LogLevel
    text: str

    def record(self, host: str) -> logging.LogRecord:
        """The log record of this line, of a process on `host`."""
        level = logging.getLevelNamesMapping()[self.level.upper()]
        record = logging.LogRecord(LOG.name, level, "", 0, self.text, (), None)
        record.created = self.time.timestamp()
        record.speaker = Speaker(self.run, host, self.role, self.robot)
        return record


class _Words(logging.Formatter):
    def __init__(self, speaker: Speaker) -> None:
        super().__init__()
        self._speaker = speaker

    def format(self, record: logging.LogRecord) -> str:
        speaker: Speaker = getattr(record, "speaker", self._speaker)
        return f"{speaker.label}: {super().format(record)}"


class _Lines(_Words):
    def format(self, record: logging.LogRecord) -> str:
        speaker = msgspec.structs.asdict(getattr(record, "speaker", self._speaker))
        time, level = datetime.fromtimestamp(record.created, UTC), record.levelname.lower()
        return msgspec.json.encode(
            {"time": time, "level": level} | speaker | {"text": logging.Formatter.format(self, record)}
        ).decode()


class _File(WatchedFileHandler):
    """Appends; starts a new file after a rotation. Drops lines that it cannot write, with one warning."""

    _warned = False

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: ARG002, N802  as in logging
        if not self._warned:
            self._warned = True
            text = f"disknav: cannot log to {self.baseFilename}: {sys.exc_info()[1]}; its lines are lost"
            print(text, file=sys.stderr, flush=True)


def words(speaker: Speaker, level: int = logging.WARNING) -> logging.Handler:
    """Writes what has at least this level to standard error, for people."""
    handler = logging.StreamHandler()
    handler.setLevel(level)
    handler.setFormatter(_Words(speaker))
    return handler


def lines(speaker: Speaker, file: Path | None) -> logging.Handler:
    """Writes everything to `file`, by default to standard error, for a launcher on another host.
    Raises UsageError if it cannot be written.
    """
    try:
        if file is not None:
            file.parent.mkdir(parents=True, exist_ok=True)
        handler = logging.StreamHandler() if file is None else _File(file, encoding="utf-8")
    except OSError as error:
        text = f"cannot log to {file}: {error.strerror}; name a folder that can be written"
        raise UsageError(text) from error
    handler.setFormatter(_Lines(speaker))
    return handler


def begin(
    name: str, run: str = "", folder: Path | None = None, *, wired: bool = False, alone: bool = False
) -> None:
    """Have `LOG` of this process log as `name`; a second call replaces the first.

    Args:
        name: of the process, such as `robot-3`.
        folder: of its file, `robot-3.jsonl`; none by default.
        wired: whether a launcher on another host reads standard error.
        alone: whether a user started it by itself, and reads there what it does, too.

    Raises UsageError if nothing can be written to `folder`.
    """
    role, _, number = name.partition("-")
    speaker = Speaker(run, "", role, int(number) if role == "robot" else None)
    least = logging.INFO if alone else logging.WARNING
    handlers = [lines(speaker, None) if wired else words(speaker, least)]
    if folder is not None:
        handlers.append(lines(speaker, folder / f"{name}.jsonl"))
    for old in LOG.handlers[:]:
        LOG.removeHandler(old)
        old.close()
    for handler in handlers:
        LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    LOG.propagate = False


_SHORT = 15  # bytes of a process's short name in Linux


def set_process_title(role: str, run: str = "") -> None:
    """Set this process's title in `ps -f` to `disknav robot 3 (run yard)`; called on its main thread.

    The short name, in `top`, is `robot 3 yard`: it begins with the role, so that a robot's number is not
    cut off.
    """
    setproctitle(f"disknav {role} (run {run})" if run else f"disknav {role}")
    setthreadtitle(f"{role} {run}".rstrip()[:_SHORT])
