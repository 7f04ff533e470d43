"""Rows and table of a campaign."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from deploy.studies.falsify.campaign import FRESH, MUTANT, Campaign, Finding
from deploy.studies.falsify.files import Files
from deploy.studies.falsify.runs.violation import MEANING
from deploy.studies.falsify.trial import Result

_ORIGINS = {FRESH: "fresh", MUTANT: "mutants"}


def rows(campaign: Campaign) -> list[dict[str, Any]]:
    """One row for fresh draws and one for mutants, in plain types.

    runs; violations (runs that show any) and of which kinds; repeated (in another order of joining);
    follows (as the second of a run, too);
    refused (draws that had to be repeated); verdicts; robot_ticks and seconds in all; slowest, s.
    """
    found = []
    for cell, origin in _ORIGINS.items():
        results = [result for (each, _), result in sorted(campaign.results.items()) if each == cell]
        if results:
            found.append({"origin": origin, **_row(results)})
    return found


def done(campaign: Campaign) -> int:
    """How many runs are known, those of shrinking not counted."""
    return sum(cell in _ORIGINS for cell, _ in campaign.results)


def listed(findings: Sequence[Finding], files: Files) -> list[dict[str, Any]]:
    """Every violation, in plain types."""
    return [
        {
            "number": finding.number,
            "kind": finding.violation.kind,
            "text": finding.violation.text,
            "tried": finding.tried,
            "file": str(path) if (path := files.path(finding)).exists() else None,
        }
        for finding in sorted(findings, key=lambda finding: finding.number)
    ]


def _row(results: Sequence[Result]) -> dict[str, Any]:
    kinds = Counter(kind for result in results for kind in {each["kind"] for each in result["violations"]})
    return {
        "runs": len(results),
        "violations": sum(bool(result["violations"]) for result in results),
        "kinds": dict(sorted(kinds.items())),
        "repeated": sum(result["repeated"] for result in results),
        "follows": sum(result["follows"] for result in results),
        "refused": sum(result["refused"] for result in results),
        "verdicts": dict(sorted(Counter(str(result["verdict"]) for result in results).items())),
        "robot_ticks": sum(result["robot_ticks"] for result in results),
        "seconds": sum(result["seconds"] for result in results),
        "slowest": max(result["seconds"] for result in results),
    }


def table(found: Sequence[Mapping[str, Any]], violations: Sequence[Mapping[str, Any]]) -> RenderableType:
    """The rows, and below them what was found, one of each kind first."""
    listing = Table(title="study falsify", title_justify="left", box=None, header_style="bold")
    for column in (
        "",
        "runs",
        "repeated",
        "follows",
        "refused",
        "robot ticks",
        "s/run",
        "slowest, s",
        *MEANING,
    ):
        listing.add_column(column, justify="right" if column else "left")
    for row in found:
        listing.add_row(
            row["origin"],
            *(str(row[name]) for name in ("runs", "repeated", "follows", "refused", "robot_ticks")),
            f"{row['seconds'] / row['runs']:.3f}",
            f"{row['slowest']:.1f}",
            *(str(row["kinds"].get(kind, 0)) for kind in MEANING),
        )
    return Group(listing, *(Text(line) for line in _lines(violations)))


def _lines(violations: Sequence[Mapping[str, Any]]) -> list[str]:
    shrunk = [each for each in violations if each["tried"]]
    lines = [f"{MEANING[each['kind']]}: {each['text'].splitlines()[-1]}; {each['file']}" for each in shrunk]
    more = len(violations) - len(shrunk)
    return [*lines, f"{more} more of the same kinds are not shrunk"] if more else lines
