"""`disknav doctor`: what is there, and what to do about what is not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from deploy.commands import options
from deploy.output import json_output
from deploy.output.exit_status import EXIT_ARRIVED, EXIT_OTHERWISE

if TYPE_CHECKING:
    from deploy.software.findings import Finding

_MARKS = {"good": ("ok", "green"), "note": ("--", "yellow"), "bad": ("!!", "red")}


def doctor(json_file: options.Json = None) -> None:
    """Say what this installation and machine have, and what to do about what they lack; runs two robots.

    ok: fine; --: fine unless what stands there is wanted; !!: fleets will not run.

    Example: disknav doctor

    Exit status: 0 fleets run, 1 something is marked with !!.
    """
    from deploy.software.findings import findings

    json_output.check(json_file)
    found = [*findings(), _trial()]
    json_output.write_json([finding._asdict() for finding in found], json_file)
    if not json_output.is_standard_output(json_file):
        _print(found)
    raise typer.Exit(EXIT_OTHERWISE if any(each.level == "bad" for each in found) else EXIT_ARRIVED)


def _trial() -> Finding:
    """Two robots as real processes for some ticks, as every fleet runs."""
    from deploy.library.load import load
    from deploy.run.fleet import Fleet
    from deploy.run.options import RunOptions
    from deploy.software.findings import Finding
    from protocol.errors import DisknavError

    try:
        with Fleet([load("head-on", ["time.limit=1.0"])], RunOptions()) as fleet:
            (report,) = fleet.execute()
    except DisknavError as error:
        return Finding("fleet", "bad", f"two robots did not run: {error}", "see what stands above")
    if report["verdict"] == "timeout" and report["collisions"] == 0:
        rate = report["ticks"] / report["wall_time"]
        return Finding("fleet", "good", f"two robots, a world and a router ran {rate:.0f} ticks a second")
    text = f"two robots ran to {report['verdict']}: {report['reason']}"
    return Finding("fleet", "bad", text, "disknav run head-on")


def _print(found: list[Finding]) -> None:
    """Line by line and not wrapped, so that commands can be copied."""
    from rich.console import Console
    from rich.text import Text

    console = Console(soft_wrap=True)
    width = max(len(finding.what) for finding in found)
    for finding in found:
        console.print(Text.assemble(_MARKS[finding.level], f"  {finding.what:<{width}}  {finding.text}"))
        if finding.remedy:
            console.print(Text.assemble(" " * (width + 4), ("→ ", "dim"), finding.remedy))
