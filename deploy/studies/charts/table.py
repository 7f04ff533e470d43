"""Rows of a study as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.studies.study import Row, Study

_WORDS = {
    "nrl_mean": "nrl",
    "nrl_std": "±",
    "nrl_error": "± error",
    "time_mean": "time, s",
    "time_error": "± error",
    "limit_mean": "limit",
    "nrl_ratio": "nrl, paired",
    "time_ratio": "time, paired",
    "time_max": "longest, s",
    "delay": "delay, s",
    "ratio": "against no delay",
    "ratio_error": "± error",
    "noise": "noise, m",
    "period": "period, s",
    "min_clearance": "clearance, m",
    "paper": "paper",
    "exact": "exact flow",
    "ticks_per_second": "ticks/s",
    "cpu_per_robot_tick_us": "CPU, µs/robot/tick",
    "memory_mb": "memory, MB",
    "memory_per_robot_mb": "MB/robot",
    "step_us": "step, µs",
}


def table(study: Study, rows: Sequence[Row]) -> RenderableType:
    """The rows, and what the study says below them."""
    listing = Table(title=f"study {study.name}", title_justify="left", box=None, header_style="bold")
    for column, form in study.columns.items():
        listing.add_column(_WORDS.get(column, column), justify="left" if form == "" else "right")
    for row in rows:
        listing.add_row(*(_cell(row.get(column), form) for column, form in study.columns.items()))
    return Group(listing, *(Text(line) for line in study.summary(rows)))


def _cell(value: object, form: str) -> str:
    return "-" if value is None else format(value, form)
