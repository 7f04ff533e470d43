"""What `disknav study` makes of its options and results: a study, its table, and the exit status."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.output import EXIT_ARRIVED, EXIT_OTHERWISE, shown
from deploy.run.options import Transport
from deploy.studies import StudyName
from deploy.studies.conditions import arrival, delay, robustness
from deploy.studies.execution import StudyOutcome
from deploy.studies.experiments import scale, tightness, tuning
from deploy.studies.peers.study import peers
from deploy.studies.study import Row, Study

_BUILD: dict[StudyName, Callable[..., Study]] = {
    "tightness": tightness,
    "tuning": tuning,
    "robustness": robustness,
    "arrival": arrival,
    "delay": delay,
    "peers": peers,
    "scale": scale,
}
_ON_PROCESSES = ("tightness", "tuning")  # others use the in-process bus by default


# column -> title, number format
_COLUMNS = {
    **{name: (name, "") for name in ("scenario", "law", "setting", "pace", "filter", "transport")},
    **{name: (name, "d") for name in ("runs", "arrived", "collisions", "robots", "room")},
    **{name: (name, "g") for name in ("k", "loss", "density")},
    "tight": ("tight", ".2f"),
    "nrl_mean": ("nrl", ".3f"),
    "nrl_std": ("±", ".3f"),
    "nrl_error": ("± error", ".3f"),
    "nrl_ratio": ("nrl, paired", ".3f"),
    "time_mean": ("time, s", ".2f"),
    "time_error": ("± error", ".2f"),
    "time_max": ("longest, s", ".1f"),
    "time_ratio": ("time, paired", ".3f"),
    "limit_mean": ("limit", ".2f"),
    "delay": ("delay, s", "g"),
    "ratio": ("against no delay", ".3f"),
    "ratio_error": ("± error", ".3f"),
    "noise": ("noise, m", "g"),
    "period": ("period, s", "g"),
    "min_clearance": ("clearance, m", ".2e"),
    "paper": ("paper", ".2f"),
    "exact": ("exact flow", ".2f"),
    "ticks_per_second": ("ticks/s", ".0f"),
    "cpu_per_robot_tick_us": ("CPU, µs/robot/tick", ".0f"),
    "memory_mb": ("memory, MB", ".0f"),
    "memory_per_robot_mb": ("MB/robot", ".1f"),
}


def table(study: Study, rows: Sequence[Row]) -> RenderableType:
    """Table of the rows, with the study's summary below."""
    listing = Table(title=f"study {study.name}", title_justify="left", box=None, header_style="bold")
    columns = [(name, *_COLUMNS[name]) for name in study.columns.split()]
    for _, title, form in columns:
        listing.add_column(title, justify="left" if form == "" else "right")
    for row in rows:
        listing.add_row(*(shown(row.get(name), form) for name, _, form in columns))
    return Group(listing, *(Text(line) for line in study.summary(rows)))


def built(
    name: StudyName,
    seed: int,
    runs: int | None,
    transport: Transport | None,
    laws: Sequence[str],
    only: Sequence[str],
) -> Study:
    """The study of this name; None for its own defaults, `laws` and `only` for `peers`."""
    arguments: dict[str, Any] = {"seed": seed} if runs is None else {"seed": seed, "runs": runs}
    if name == "scale" and transport is not None:
        arguments["transports"] = (transport,)
    if name == "peers":
        arguments |= {"laws": laws, "only": only}
    return _BUILD[name](**arguments)


def usual_transport(name: StudyName) -> Transport:
    """Where the runs of a study take place by default."""
    return "routed" if name in _ON_PROCESSES else "local"


def status(study: Study, outcome: StudyOutcome, file: Path | None) -> int:
    """The exit status; says how to continue a study that was stopped."""
    if not outcome.complete:
        further = "repeat the command to continue" if file else "add --json FILE to be able to continue"
        print(f"disknav: stopped; {further}", file=sys.stderr)
        return EXIT_OTHERWISE
    return EXIT_ARRIVED if study.sound(outcome.rows) else EXIT_OTHERWISE
