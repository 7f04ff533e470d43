"""Finished runs of a study, one JSON line each, so that a study that was stopped goes on where it was."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

Result = dict[str, Any]


class RunLog:
    """Results by key, kept in a file that only grows; a context manager.

    A line that a crash cut short is ignored, and its run is run again.
    """

    def __init__(self, path: Path | None, *, fresh: bool = False) -> None:
        """Read what `path` holds (None: keep nothing); `fresh` begins it anew."""
        self._path = path
        self.known: dict[str, Result] = {}
        if path is not None and fresh:
            path.unlink(missing_ok=True)
        torn = False
        if path is not None and path.exists():
            torn = self._read(path)
        self._file = None if path is None else path.open("a", encoding="utf-8")
        if torn and self._file is not None:
            self._file.write("\n")

    def _read(self, path: Path) -> bool:
        """Take over every whole line; whether the last one is torn."""
        text = path.read_text(encoding="utf-8", errors="replace")
        for line in text.splitlines():
            entry = _entry(line)
            if entry is not None:
                self.known[entry[0]] = entry[1]
        return bool(text) and not text.endswith("\n")

    def __enter__(self) -> RunLog:
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()

    def add(self, key: str, result: Result) -> None:
        """Keep one result, at once."""
        self.known[key] = result
        if self._file is not None:
            self._file.write(json.dumps({"key": key, "result": result}) + "\n")
            self._file.flush()


def _entry(line: str) -> tuple[str, Result] | None:
    try:
        entry = json.loads(line)
        return str(entry["key"]), dict(entry["result"])
    except (ValueError, TypeError, KeyError):
        return None
