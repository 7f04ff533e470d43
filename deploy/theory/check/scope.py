"""Which theorem speaks of a scenario: those about navigation functions are about worlds of one kind each."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from protocol.geometry import Disk
from protocol.geometry.sphere_world import ROOM, obstructed
from protocol.scenario.model import Scenario

Theorem = Literal["Karagoz-Bozma-Koditschek", "Koditschek-Rimon"]


def theorem_for(scenario: Scenario) -> tuple[Theorem | None, tuple[str, ...]]:
    """The theorem whose world a scenario is, and if there is none, why not.

    - Robots alone in a disk: Karagoz, Bozma and Koditschek, Theorem 1.
    - One robot in a disk among disks that stand apart, so that it passes between any two and between each and
      the boundary: a sphere world (Koditschek and Rimon, "Robot navigation functions on manifolds with
      boundary", 1990).
    """
    reasons = []
    if not isinstance(scenario.workspace.shape, Disk):
        reasons.append("the workspace is a polygon, and both theorems are about disks")
    shapes = scenario.shapes
    polygons = [number for number, shape in shapes.items() if not isinstance(shape, Disk)]
    if polygons:
        reasons.append(f"{_counted(len(polygons), 'thing')} among which robots move {_are(polygons)} no disk")
    if scenario.parts:
        reasons.append("no theorem is known for parts that are carried")
    if shapes and len(scenario.robots) > 1:
        reasons.append("no theorem is known for several robots among things that stand")
    if shapes and not reasons:
        reasons += _not_apart(scenario)
    if reasons:
        return None, tuple(reasons)
    return ("Koditschek-Rimon" if shapes else "Karagoz-Bozma-Koditschek"), ()


def _not_apart(scenario: Scenario) -> Iterator[str]:
    """Things that one robot does not pass between."""
    pairs = obstructed(scenario.workspace.shape, scenario.shapes, scenario.robots[0].radius)
    for one, other in pairs:
        between = f"thing {other} and the boundary" if one == ROOM else f"things {one} and {other}"
        yield f"the robot does not pass between {between}"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _are(items: list[int]) -> str:
    return "is" if len(items) == 1 else "are"
