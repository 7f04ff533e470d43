"""The parts of a document that can be relied on when other parts are malformed."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from protocol.scenario.shape import Document, Step, Steps


class Sound:
    """Reads a document, passing over every field that has the wrong type or range.

    malformed: steps of those fields.
    """

    def __init__(self, document: Document, malformed: Collection[Steps]) -> None:
        self._document = document
        self._malformed = set(malformed)
        self._touched = {steps[:n] for steps in malformed for n in range(len(steps) + 1)}

    def get(self, *steps: Step, default: Any = None) -> Any:
        """The value at `steps`, `default` where it is absent, None where it or a part of it is malformed."""
        if steps in self._touched:
            return None
        value: Any = self._document
        for n, step in enumerate(steps):
            if steps[: n + 1] in self._malformed:
                return None
            if isinstance(value, dict) and step not in value:
                return default
            value = value[step]
        return value

    def size(self, *steps: Step) -> int:
        """Number of elements of the array at `steps`, malformed ones included; 0 where there is none."""
        value: Any = self._document
        for step in steps:
            if isinstance(value, dict):
                value = value.get(step)
            elif isinstance(value, list) and isinstance(step, int):
                value = value[step]
            else:
                return 0
        return len(value) if isinstance(value, list) else 0
