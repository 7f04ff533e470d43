"""The monitor in a terminal: a live table."""

from __future__ import annotations

from typing import Any

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from deploy.output import shown
from deploy.telemetry.monitor.snapshot import Source
from protocol.process.signals import STOP

REFRESH = 0.5  # s; drawing takes some milliseconds
_COLUMNS = ("robot", "status", "goal, mm", "age, s", "behind", "1/s", "error, mm", "rejected", "restarts")
_PHASES = {
    "searching": "looking for the run",
    "gathering": "waiting for robots",
    "running": "running",
    "paused": "paused",
    "halted": "emergency stop",
    "lost": "the world is gone",
}
_ALARMS = ("collision", "aborted", "halted", "lost")
_STYLES = {"arrived": "bold green", **dict.fromkeys(_ALARMS, "bold red")}


def show(source: Source, console: Console | None = None) -> str:
    """Show `source` until its run has ended, or a signal arrives; returns the verdict, "" if none."""
    with Live(console=console, auto_refresh=False) as live:
        while True:
            frame = source.snapshot()
            live.update(table(frame), refresh=True)
            if frame["phase"] in ("ended", "lost") or STOP.wait(REFRESH):
                return str(frame["verdict"])


def table(frame: dict[str, Any]) -> RenderableType:
    """One frame as a table."""
    listing = Table(box=None, padding=(0, 1), header_style="dim")
    for column in _COLUMNS:
        listing.add_column(column, justify="left" if column == "status" else "right", no_wrap=True)
    for row in frame["robots"]:
        style = "bold red" if row["alarm"] else "green" if row["status"] == "at goal" else ""
        listing.add_row(*_cells(row), style=style)
    reason = [Text(frame["reason"])] if frame["reason"] else []
    return Group(_headline(frame), *reason, listing)


def _headline(frame: dict[str, Any]) -> Text:
    smallest = "-" if frame["smallest"] is None else f"{1000 * frame['smallest']:.2f} mm"
    standing = frame["verdict"] or _PHASES[frame["phase"]]
    style = _STYLES.get(frame["verdict"] or frame["phase"], "bold yellow" if frame["verdict"] else "bold")
    return Text.assemble(
        (f"{frame['run']}  ", "bold"),
        (standing, style),
        f"  t = {frame['time']:.2f} s  tick {frame['tick']}, {frame['pace']:.0f} per second",
        f"  smallest clearance {smallest}",
    )


def _cells(row: dict[str, Any]) -> list[str]:
    mark = "✕ " if row["alarm"] else ""
    return [
        str(row["id"]),
        mark + row["status"],
        f"{1000 * row['distance']:.1f}",
        shown(row["age"], ".1f"),
        shown(row["age_ticks"], ".0f"),
        shown(row["rate"], ".0f"),
        shown(None if row["bound"] is None else 1000 * row["bound"], ".1f"),
        str(row["rejected"]),
        str(row["restarts"]),
    ]
