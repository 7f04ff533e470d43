"""The reports of a fleet's runs, as the world's process tells them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from protocol.errors import MessageError
from world.judge.verdict import VERDICTS

Report = dict[str, Any]
# What the launcher and its tables rely on in a report.
_PROMISED = {
    *("verdict", "reason", "scenario", "robots", "law", "filter", "k", "arrived", "collisions", "faults"),
    *("path_lengths", "lateral_deviation", "nrl", "tight", "min_clearance", "phi", "trajectory_sha256"),
    *("run_number", "ticks", "sim_time", "wall_time", "messages", "missed_commands"),
}


class Reports:
    """One a run, in their order, whatever is told twice.

    Args:
        runs: how many there are.
        on_report: is told each as soon as it is there.
        digest: what is kept of each.
        expired: what to add to the reason of one that did not arrive.

    Attributes:
        all: those there are; the list stays the same.
    """

    def __init__(
        self,
        runs: int,
        on_report: Callable[[Report], None] | None = None,
        digest: Callable[[Report], Report] = lambda report: report,
        expired: Callable[[], str] = lambda: "",
    ) -> None:
        self.all: list[Report] = []
        self._runs = runs
        self._on_report, self._digest, self._expired = on_report, digest, expired

    def add(self, text: str) -> None:
        """Take one, a JSON object, unless its run has one: a later life of the world may tell it again.

        Raises:
            MessageError: it is not JSON, or not what a world reports.
        """
        report = _read(text)
        if report["run_number"] not in range(self._runs):
            raise MessageError("shape", f"result: there is no run {report['run_number']}")
        if any(report["run_number"] == other["run_number"] for other in self.all):
            return
        if report["verdict"] != "arrived":
            report["reason"] = f"{report['reason']}{self._expired()}".removeprefix("; ")
        self.all.append(self._digest(report))
        self.all.sort(key=lambda each: int(each["run_number"]))
        if self._on_report is not None:
            self._on_report(report)


def _read(text: str) -> Report:
    try:
        report = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MessageError("shape", f"result: the report is not JSON ({error})") from None
    if not isinstance(report, dict) or not report.keys() >= _PROMISED or report["verdict"] not in VERDICTS:
        raise MessageError("shape", f"result: the report lacks one of {', '.join(sorted(_PROMISED))}")
    if type(report["run_number"]) is not int:
        raise MessageError("type", "result: the report's `run_number` is no integer")
    return report
