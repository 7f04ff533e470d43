"""The result of a run: the world's report, or a substitute, with the launcher's facts."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.output import EXIT_ARRIVED, EXIT_FAULT, EXIT_OTHERWISE, grid, print_whole, shown
from deploy.processes.table import is_router
from deploy.run.options import RunOptions
from protocol.errors import MessageError
from protocol.messages import Clock
from protocol.scenario.model import Scenario
from world.judge.verdict import VERDICTS
from world.report import result_of
from world.world import WorldCore

RunReport = dict[str, Any]
RunResult = dict[str, Any]

INTERRUPTED = "stopped by the user"  # reason after Ctrl-C
# Fields of a report that the launcher needs.
_PROMISED = {
    *("verdict", "reason", "scenario", "robots", "law", "filter", "k", "arrived", "collisions", "faults"),
    *("path_lengths", "lateral_deviation", "nrl", "tight", "min_clearance", "phi", "log_potential"),
    *("ticks", "sim_time", "wall_time", "messages", "missed_commands", "trajectory_sha256"),
}
_UNKNOWN = ("min_clearance", "nrl", "trajectory_sha256", "positions")
_PER_ROBOT = ("path_lengths", "lateral_deviation")
_COLUMNS = ("robot", "arrived", "path, m", "aside, m", "pid", "restarts", "cpu, s", "memory, MB", "exit")
_STYLES = {"arrived": "bold green", "collision": "bold red", "interrupted": "yellow"}


def read_report(text: str) -> RunReport:
    """Parse the report of a world's process; raises MessageError if it is not JSON, or fields are missing."""
    try:
        report = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MessageError("shape", f"result: the report is not JSON ({error})") from None
    if not isinstance(report, dict) or not report.keys() >= _PROMISED or report["verdict"] not in VERDICTS:
        raise MessageError("shape", f"result: the report lacks one of {', '.join(sorted(_PROMISED))}")
    return report


def unjudged(scenario: Scenario, last: Clock | None, wall_time: float) -> RunReport:
    """Substitute for the report of a lost world, as of the last Clock received, if any; unknown values are
    None. `wall_time` is s since the start of the fleet.
    """
    report = result_of(WorldCore(scenario))
    report.update(dict.fromkeys(_UNKNOWN))
    report.update({name: {} for name in _PER_ROBOT})
    report.update(messages={"published": 0, "received": 0, "rejected": {}}, wall_time=wall_time)
    if last is not None:
        report.update(ticks=last.tick, sim_time=last.time)
        report["phi"]["last"], report["log_potential"]["last"] = last.phi, None
    return report


def complete(
    report: Mapping[str, Any],
    options: RunOptions,
    processes: list[dict[str, Any]],
    recordings: Sequence[str] = (),
) -> RunResult:
    """The result: report, options, processes, rates, and the files of the recording."""
    result = dict(report)
    wall = float(result.get("wall_time", 0.0))
    ticks = int(result.get("ticks", 0))
    result.update(
        run=options.run,
        mode=options.mode,
        transport=options.transport,
        ticks_per_second=ticks / wall if wall > 0.0 else 0.0,
        processes=processes,
        recordings=list(recordings),
    )
    return result


def exit_status(result: Mapping[str, Any]) -> int:
    """0 arrived, 3 ended before the first tick, 1 any other verdict; a signal's exit status has priority."""
    verdict = result["verdict"]
    if verdict == "aborted" and not result["ticks"]:
        return EXIT_FAULT
    return EXIT_ARRIVED if verdict == "arrived" else EXIT_OTHERWISE


def kept_status(result: Mapping[str, Any]) -> int:
    """Exit status of a fleet without end: a signal's, 1 after a collision, 3 if it ended by itself."""
    return EXIT_OTHERWISE if result["collisions"] else EXIT_FAULT


def show(result: Mapping[str, Any]) -> None:
    print_whole(table(result))


def table(result: Mapping[str, Any]) -> RenderableType:
    """Summary of a run for the terminal; the column aside is the lateral deviation."""
    verdict = result["verdict"]
    headline = Text.assemble(
        (f"{result['scenario']}: ", "bold"),
        (verdict, _STYLES.get(verdict, "bold yellow")),
        f"  {result.get('reason') or ''}",
    )
    return Group(headline, _figures(result), _robots(result))


def _figures(result: Mapping[str, Any]) -> Table:
    phi, level, messages = result["phi"], result["log_potential"], result["messages"]
    rejected = sum(messages["rejected"].values())
    first, last = (shown(level[end], ".2f") for end in ("first", "last"))
    return grid(
        {
            "time": f"{result['sim_time']:.2f} s simulated, {result['wall_time']:.2f} s real",
            "ticks": f"{result['ticks']} at {result['ticks_per_second']:.0f} per second, "
            f"{result['transport']}",
            "path": f"nrl {shown(result['nrl'], '.3f')}, tight {shown(result['tight'], '.2f')}",
            "clearance": f"{shown(result['min_clearance'], '.5f')} m smallest, "
            f"{result['collisions']} collisions",
            "phi": f"{phi['first']:.4f} to {phi['last']:.4f}, {phi['increases']} increases",
            "potential": f"log10(gamma / beta^(1/k)): {first} to {last}",
            "control": f"{result['law']}, k = {result['k']:g}, filter {result['filter']}",
            "messages": f"{messages['published']} published, {messages['received']} received, "
            f"{rejected} rejected",
            "missed": f"{result['missed_commands']} commands",
            "trajectory": result["trajectory_sha256"] or "-",
        }
    )


def _robots(result: Mapping[str, Any]) -> Table:
    listing = Table(box=None, padding=(0, 1), header_style="dim")
    for column in _COLUMNS:
        listing.add_column(column, justify="right", no_wrap=True)
    processes = {process["name"]: process for process in result["processes"]}
    for robot in result["robots"]:
        row = processes.get(f"robot-{robot}", {})
        arrived = "yes" if robot in result["arrived"] else "no"
        ways = [shown(result[name].get(str(robot)), ".3f") for name in ("path_lengths", "lateral_deviation")]
        listing.add_row(str(robot), arrived, *ways, *_process_cells(row))
    for name, row in processes.items():
        if name == "world" or is_router(name):
            listing.add_row(name, "", "", "", *_process_cells(row))
    return listing


def _process_cells(row: Mapping[str, Any]) -> list[str]:
    if not row:
        return ["-"] * 5
    cells = (row["pid"], row["restarts"], f"{row['cpu_s']:.2f}", f"{row['max_rss_mb']:.0f}", row["exit_code"])
    return ["" if cell is None else str(cell) for cell in cells]
