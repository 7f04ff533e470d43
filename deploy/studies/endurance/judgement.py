"""What a trial of endurance is judged by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rich.table import Table
from rich.text import Text


@dataclass(frozen=True)
class Criterion:
    """One thing that has to hold, what was measured, and whether it holds; None: not judged."""

    what: str
    measured: str
    holds: bool | None


def passed(criteria: Sequence[Criterion]) -> bool:
    """Whether nothing that is judged fails."""
    return all(each.holds is not False for each in criteria)


def plain(criteria: Sequence[Criterion]) -> list[dict[str, Any]]:
    """For JSON."""
    return [asdict(each) for each in criteria]


_MARKS = {True: ("holds", "bold green"), False: ("fails", "bold red"), None: ("reported", "dim")}


def criteria_table(criteria: Sequence[Criterion]) -> Table:
    """For people."""
    listing = Table(box=None, padding=(0, 1), show_header=False)
    for each in criteria:
        word, style = _MARKS[each.holds]
        listing.add_row(Text(word, style=style), each.what, each.measured)
    return listing
