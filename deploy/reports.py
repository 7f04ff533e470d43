"""The reports of a fleet's runs, as they come in: over the network, and from the world's own process."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

Report = dict[str, Any]


class Reports:
    """One a turn, in their order, whatever arrives twice.

    Attributes:
        all: those there are; the list stays the same.
    """

    def __init__(self, on_report: Callable[[Report], None] | None = None) -> None:
        """`on_report` is told each as soon as it is there."""
        self.all: list[Report] = []
        self._on_report = on_report

    def add(self, text: str) -> None:
        """Take one, a JSON object, unless its turn has one: a world may tell it, and a later life again."""
        report: Report = json.loads(text)
        if any(report["turn"] == other["turn"] for other in self.all):
            return
        self.all.append(report)
        self.all.sort(key=lambda each: int(each["turn"]))
        if self._on_report is not None:
            self._on_report(report)
