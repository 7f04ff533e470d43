"""What no run may show, whatever its scenario."""

from __future__ import annotations

import math
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Kind = Literal["contact", "wall", "thing", "error", "aborted", "endless", "order", "second", "bus"]

MEANING: dict[Kind, str] = {
    "contact": "two robots touch",
    "wall": "a robot leaves the workspace",
    "thing": "a robot touches what stands",
    "error": "an exception ends the run",
    "aborted": "the world gives up, though nobody is missing for good",
    "endless": "the run does not end",
    "order": "the trajectory depends on the order in which robots join",
    "second": "the trajectory depends on the scenario before, on the same robots",
    "bus": "the trajectory on real processes is not that within one process",
}
_EXPECTED = "down for good"  # the one reason for which the judge aborts


@dataclass(frozen=True)
class Violation:
    """One thing that must not be.

    Attributes:
        kind: what it breaks.
        text: what exactly it is.
        place: where in the code an error is.
        follows: whether it is of a run in which the scenario is the second one.
    """

    kind: Kind
    text: str
    place: str = ""
    follows: bool = False

    @property
    def making(self) -> tuple[str, str]:
        """What violations of the same making have in common."""
        return f"{self.kind}, second" if self.follows else self.kind, self.place


def violations(report: Mapping[str, Any]) -> list[Violation]:
    """What is wrong with a run that has ended, by its report (in plain types, as the world writes it)."""
    found = [_contact(contacts) for contacts in _by_kind(report["contacts"]) if contacts]
    if report["verdict"] == "aborted" and _EXPECTED not in report["reason"]:
        found.append(Violation("aborted", report["reason"]))
    if not math.isfinite(report["min_clearance"]):
        found.append(Violation("error", f"the smallest clearance is {report['min_clearance']}", "clearance"))
    return found


def raised(error: Exception) -> Violation:
    """What an exception that ended a run says."""
    where = traceback.extract_tb(error.__traceback__)[-1]
    text = "".join(traceback.format_exception(error, limit=-3)).strip()
    return Violation("error", text, f"{type(error).__name__} in {where.name}")


def other_trajectory(kind: Literal["order", "second", "bus"], one: str, other: str, what: str) -> Violation:
    """Two digests of what should be one trajectory."""
    return Violation(kind, f"trajectory {one[:12]}, but {other[:12]} {what}")


def _by_kind(contacts: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], ...]:
    """Contacts between robots, those with the boundary, and those with things."""
    inner = [contact for contact in contacts if contact["pair"][0] > 0]
    wall = [contact for contact in contacts if contact["pair"][0] == 0]
    return inner, wall, [contact for contact in contacts if contact["pair"][0] < 0]


def _contact(contacts: list[dict[str, Any]]) -> Violation:
    deepest = min(contacts, key=lambda contact: float(contact["deepest"]))
    one, other = deepest["pair"]
    depth, begin, end = -deepest["deepest"], deepest["from"], deepest["until"]
    when = f"by {depth:.3g} m, {begin:.6g} to {end:.6g} s"
    if one == 0:
        return Violation("wall", f"robot {other} is beyond the boundary {when}")
    if one < 0:
        return Violation("thing", f"robot {other} and thing {-one} overlap {when}")
    return Violation("contact", f"robots {one} and {other} overlap {when}")
