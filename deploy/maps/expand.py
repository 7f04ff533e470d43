"""Replaces the `map` of a scenario's document by obstacles and a workspace."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from protocol.errors import Problem, ScenarioError
from protocol.scenario.model import FloorPlan
from protocol.scenario.tables import Document, read_table, written

_MOST_PIECES = 5000  # largest number of obstacles of a scenario


def expanded(document: Document, folder: Path, source: str) -> Document:
    """The document with the map's obstacles, after its own, in place of the map.

    Args:
        document: of a scenario; unchanged without a map.
        folder: folder of the map's file.
        source: of the document, for errors.

    Raises:
        ScenarioError: `map` is malformed, or a robot's start or goal is not free.
        MapError: the file cannot be read, or describes no map.
        UsageError: the libraries that read maps are not installed.
    """
    if not isinstance(document.get("map"), dict):
        return document
    plan, findings = read_table(document["map"], FloorPlan)
    if findings:
        problems = [Problem(written(("map", *steps)), text) for steps, text in findings]
        raise ScenarioError(source, problems)
    from deploy.maps.occupancy import read_map
    from deploy.maps.pieces import floor_plan

    grid = read_map(folder / plan.file)
    radius = min((radius for radius in _numbers(document, "radius")), default=0.0)
    workspace = document.get("workspace")
    found = floor_plan(grid, plan.error, radius, unknown_is_free=plan.unknown == "free", rim=bool(workspace))
    problems = []
    if not found.workspace:
        problems = [Problem("map.file", f"has no free space for a disk of {radius:g} m")]
    elif len(found.obstacles) > _MOST_PIECES:
        text = f"{len(found.obstacles)} obstacles are more than {_MOST_PIECES}: allow a larger one"
        problems = [Problem("map.error", text)]
    else:
        problems = [
            Problem(
                f"robots[{index}].{end}",
                f"is not in the free space of the map, but {_place(grid.cell(*point))}",
            )
            for index, end, point in _ends(document)
            if (cell := grid.cell(*point)) is None or not found.free[cell]
        ]
    if problems:
        raise ScenarioError(source, problems)
    rest = {key: value for key, value in document.items() if key != "map"}
    obstacles = [
        *rest.get("obstacles", []),
        *({"points": list(map(list, piece))} for piece in found.obstacles),
    ]
    if not workspace:
        workspace = {"points": list(map(list, found.workspace))}
    return rest | {"obstacles": obstacles, "workspace": workspace}


def blamed_on_map(error: ScenarioError, own: int) -> ScenarioError:
    """The error with the map's obstacles, those after the document's `own` ones, named as such."""
    return ScenarioError(
        error.source, [Problem(_of_map(each.path, own), each.text) for each in error.problems]
    )


def _of_map(path: str, own: int) -> str:
    if not path.startswith("obstacles["):
        return path
    number = int(path[len("obstacles[") : path.index("]")])
    return path if number < own else f"map (obstacle {number - own + 1})"


def _place(cell: tuple[int, int] | None) -> str:
    return "outside of it" if cell is None else f"in column {cell[1]}, row {cell[0]} from below"


def _robots(document: Document) -> Iterator[tuple[int, Document]]:
    robots = document.get("robots")
    if isinstance(robots, list):
        yield from ((index, each) for index, each in enumerate(robots) if isinstance(each, dict))


def _numbers(document: Document, key: str) -> Iterator[float]:
    """Numbers of robots under `key`; invalid values are reported later."""
    for _, robot in _robots(document):
        if _is_number(robot.get(key)):
            yield robot[key]


def _ends(document: Document) -> Iterator[tuple[int, str, tuple[float, float]]]:
    for index, robot in _robots(document):
        for end in ("start", "goal"):
            point = robot.get(end)
            if isinstance(point, list) and len(point) == 2 and all(map(_is_number, point)):
                yield index, end, (point[0], point[1])


def _is_number(value: Any) -> bool:
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and math.isfinite(value)
        and value > -1e9
    )
