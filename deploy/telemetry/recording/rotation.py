"""When a recording continues in another file, and how that file is named."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from math import inf
from pathlib import Path

from protocol.errors import UsageError

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
    """Parse the values of `--rotate`: `500MB`, `1h`, or one of each.

    Raises:
        UsageError: a value is neither a size nor an age.
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


def next_free(path: Path) -> Path:
    """The first of `run-2.mcap`, `run-3.mcap`... that does not exist, beside `run.mcap`."""
    parts = (path.with_stem(f"{path.stem}-{number}") for number in count(2))
    return next(part for part in parts if not part.exists())
