"""The command `disknav study`: from its options to table, file and exit status."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


def find(
    name: StudyName,
    runs: int | None,
    seed: int,
    transport: Transport | None,
    *,
    laws: Sequence[str] = (),
    only: Sequence[str] = (),
) -> Study:
    """The study, with `runs` runs per cell (default: the study's own) from `seed` on.

    Args:
        laws, only: arguments of `peers`.
    """
    arguments: dict[str, Any] = {"seed": seed} if runs is None else {"seed": seed, "runs": runs}
    if name == "scale" and transport is not None:
        arguments["transports"] = (transport,)
    if name == "peers":
        arguments |= {"laws": laws, "only": only}
    return _BUILD[name](**arguments)


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
    "step_us": ("step, µs", ".0f"),
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


@dataclass(frozen=True)
class StudyRequest:
    """Options of the command line."""

    name: StudyName
    runs: int | None
    jobs: int
    seed: int
    settings: tuple[str, ...]
    transport: Transport | None
    shard: Shard
    target: Path | None
    fresh: bool
    quiet: bool
    laws: tuple[str, ...] = ()
    only: tuple[str, ...] = ()

    @property
    def file(self) -> Path | None:
        """File to write, if any."""
        return None if is_standard_output(self.target) else self.target


def perform(request: StudyRequest) -> int:
    """Run the study and print or write its results; returns the exit status.

    Raises:
        UsageError, ScenarioError: the study, a setting or the file is invalid.
        ProcessError: a worker or a fleet was lost; repeat the call to continue.
    """
    transport: Transport = request.transport or ("routed" if request.name in _ON_PROCESSES else "local")
    jobs = 1 if request.name == "scale" else request.jobs  # its figures are speeds
    study = find(
        request.name,
        request.runs,
        request.seed,
        request.transport,
        laws=request.laws,
        only=request.only,
    ).adjusted(request.settings)
    _check(request, study)
    quiet = request.quiet or is_standard_output(request.target)
    with RunLog(_log_path(request.file), fresh=request.fresh) as log:
        outcome = execute(study, transport, log, jobs=jobs, quiet=quiet, shard=request.shard)
    document = {
        "study": study.name,
        "rows": outcome.rows,
        "provenance": provenance(request.seed, transport, jobs)
        | {
            "shard": str(request.shard),
            "settings": list(request.settings),
            "complete": outcome.complete,
        },
    }
    write_json(document, request.target)
    if not quiet:
        Console(width=None if sys.stdout.isatty() else _PAPER).print(table(study, outcome.rows))
    return _status(study, outcome, request.file)


def _check(request: StudyRequest, study: Study) -> None:
    if request.file is not None and not request.file.parent.is_dir():
        raise UsageError(f"{request.file}: the folder {request.file.parent} does not exist")
    check_json(request.target)
    cell = study.cells[0]
    cell.build(cell.seeds[0])


def _log_path(file: Path | None) -> Path | None:
    return None if file is None else file.with_name(file.name + ".runs.jsonl")


def _status(study: Study, outcome: StudyOutcome, file: Path | None) -> int:
    if not outcome.complete:
        further = "repeat the command to continue" if file else "add --json FILE to be able to continue"
        print(f"disknav: stopped; {further}", file=sys.stderr)
        return EXIT_OTHERWISE
    return EXIT_ARRIVED if study.sound(outcome.rows) else EXIT_OTHERWISE
