"""Replaces the `map` of a scenario's document by obstacles and a workspace."""

from __future__ import annotations

import math
from pathlib import Path

from protocol.errors import Problem, ScenarioError
from protocol.geometry import ConvexPolygon
from protocol.scenario.model import Scenario
from protocol.scenario.places import lies_outside
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
    scenario, findings = read_table(document, Scenario)
    plan, wrong = scenario.map, {steps[0] for steps, _ in findings if steps}
    if plan is None or not isinstance(document["map"], dict):
        return document
    if "map" in wrong:
        problems = [Problem(written(steps), text) for steps, text in findings if steps[:1] == ("map",)]
        raise ScenarioError(source, problems)
    from deploy.maps.occupancy import read_map
    from deploy.maps.pieces import floor_plan

    grid = read_map(folder / plan.file)
    radius = min((spec.radius for spec in scenario.robots if spec.radius > 0.0), default=0.0)
    given = bool(document.get("workspace"))
    found = floor_plan(grid, plan.error, radius, unknown_is_free=plan.unknown == "free", rim=given)
    pieces, room = found.obstacles, scenario.workspace
    if given and "workspace" not in wrong and not room.defect():
        pieces = [piece for piece in pieces if not lies_outside(ConvexPolygon(piece), room.shape)]
    if not found.workspace:
        problems = [Problem("map.file", f"has no free space for a disk of {radius:g} m")]
    elif len(pieces) > _MOST_PIECES:
        text = f"{len(pieces)} obstacles are more than {_MOST_PIECES}: allow a larger one"
        problems = [Problem("map.error", text)]
    else:
        problems = [
            Problem(
                f"robots[{index}].{end}",
                f"is not in the free space of the map, but {_place(grid.cell(*point))}",
            )
            for index, spec in enumerate(scenario.robots)
            for end, point in (("start", spec.start), ("goal", spec.goal))
            if all(map(math.isfinite, point))
            and ((cell := grid.cell(*point)) is None or not found.free[cell])
        ]
    if problems:
        raise ScenarioError(source, problems)
    rest = {key: value for key, value in document.items() if key != "map"}
    obstacles = [*rest.get("obstacles", []), *({"points": list(map(list, piece))} for piece in pieces)]
    workspace = document["workspace"] if given else {"points": list(map(list, found.workspace))}
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
