"""The command `disknav study`: from its options to table, file and exit status."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.output import EXIT_ARRIVED, EXIT_OTHERWISE, check_json, is_standard_output, write_json
from deploy.run.options import Transport
from deploy.software import provenance
from deploy.studies import StudyName
from deploy.studies.conditions import arrival, delay, robustness
from deploy.studies.execution import RunLog, StudyOutcome, execute
from deploy.studies.experiments import scale, tightness, tuning
from deploy.studies.peers.study import peers
from deploy.studies.study import Row, Shard, Study
from protocol.errors import UsageError

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
        listing.add_row(*(_cell(row.get(name), form) for name, _, form in columns))
    return Group(listing, *(Text(line) for line in study.summary(rows)))


def _cell(value: object, form: str) -> str:
    return "-" if value is None else format(value, form)


_PAPER = 160  # width without a terminal


def perform(
    name: StudyName,
    *,
    runs: int | None = None,
    jobs: int = 1,
    seed: int = 0,
    settings: Sequence[str] = (),
    transport: Transport | None = None,
    shard: Shard = Shard(),
    target: Path | None = None,
    fresh: bool = False,
    quiet: bool = False,
    laws: Sequence[str] = (),
    only: Sequence[str] = (),
) -> int:
    """Run a study and print or write its results; returns the exit status.

    Args:
        runs: per cell, from `seed` on; default the study's own.
        target: of the JSON document.
        fresh: discard the results of an earlier call.
        laws, only: arguments of `peers`.

    Raises:
        UsageError, ScenarioError: the study, a setting or the file is invalid.
        ProcessError: a worker or a fleet was lost; repeat the call to continue.
    """
    bus: Transport = transport or ("routed" if name in _ON_PROCESSES else "local")
    jobs = 1 if name == "scale" else jobs  # its figures are speeds
    arguments: dict[str, Any] = {"seed": seed} if runs is None else {"seed": seed, "runs": runs}
    if name == "scale" and transport is not None:
        arguments["transports"] = (transport,)
    if name == "peers":
        arguments |= {"laws": laws, "only": only}
    study = _BUILD[name](**arguments).adjusted(settings)
    file = None if is_standard_output(target) else target
    if file is not None and not file.parent.is_dir():
        raise UsageError(f"{file}: the folder {file.parent} does not exist")
    check_json(target)
    study.cells[0].build(study.cells[0].seeds[0])  # an invalid setting is found before any run
    quiet = quiet or is_standard_output(target)
    runs_file = None if file is None else file.with_name(f"{file.name}.runs.jsonl")
    with RunLog(runs_file, fresh=fresh) as log:
        outcome = execute(study, bus, log, jobs=jobs, quiet=quiet, shard=shard)
    told = {"shard": str(shard), "settings": list(settings), "complete": outcome.complete}
    document = {
        "study": study.name,
        "rows": outcome.rows,
        "provenance": provenance(seed, bus, jobs) | told,
    }
    write_json(document, target)
    if not quiet:
        Console(width=None if sys.stdout.isatty() else _PAPER).print(table(study, outcome.rows))
    return _status(study, outcome, file)


def _status(study: Study, outcome: StudyOutcome, file: Path | None) -> int:
    if not outcome.complete:
        further = "repeat the command to continue" if file else "add --json FILE to be able to continue"
        print(f"disknav: stopped; {further}", file=sys.stderr)
        return EXIT_OTHERWISE
    return EXIT_ARRIVED if study.sound(outcome.rows) else EXIT_OTHERWISE
