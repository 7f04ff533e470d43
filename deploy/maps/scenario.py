"""Maps in scenarios: obstacles and a workspace in place of a document's `map`; and scenarios on a map, with
random starts and goals of robots in its free space.
"""

from __future__ import annotations

import math
from os.path import relpath
from pathlib import Path

import numpy as np
from scipy import ndimage

from deploy.maps.occupancy import Mask, Occupancy, read_map
from deploy.maps.pieces import floor_plan
from protocol.draws import Purpose, generator
from protocol.errors import Problem, ScenarioError, UsageError
from protocol.geometry import ConvexPolygon
from protocol.scenario.file import parse_document
from protocol.scenario.model import FloorPlan, Position, Scenario
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


_APART = 2.5  # radii between two starts or two goals
_TRIES = 20_000
_ERROR = FloorPlan("").error


def map_scenario(file: Path, count: int, radius: float, seed: int, folder: Path, error: float) -> Scenario:
    """A checked scenario with the map `file`, to be written into `folder`; raises as `on_map`."""
    document = on_map(file, count, radius, seed, error=error)
    parse_document(expanded(document, folder, document["name"]), document["name"])
    document["map"]["file"] = relpath(file, folder)
    return read_table(document, Scenario)[0]


def on_map(
    file: Path, count: int, radius: float, seed: int, *, speed: float = 0.5, error: float = _ERROR
) -> Document:
    """Document of a scenario with the map `file`: `count` robots of `radius` (m), with obstacles that reach
    at most `error` (m) into free space.

    Raises MapError if the file describes no map, UsageError if the robots have no room.
    """
    grid = read_map(file)
    room = _room(grid, (radius + 2.0 * error) / grid.resolution)
    draw = generator(seed, Purpose.SCENARIO)
    starts, goals = (_places(grid, room, count, _APART * radius, draw) for _ in range(2))
    rows, columns = grid.occupied.shape
    limit = 10.0 * grid.resolution * (rows + columns) / speed
    return {
        "name": f"{file.stem}-{count}",
        "seed": seed,
        "time": {"step": 0.1, "limit": float(round(limit)), "tolerance": 0.05},
        "control": {"speed": speed},
        "map": {"file": str(file.resolve())} | ({} if error == _ERROR else {"error": error}),
        "robots": [
            {"id": n + 1, "radius": radius, "start": list(starts[n]), "goal": list(goals[n])}
            for n in range(count)
        ],
    }


def _room(grid: Occupancy, clear: float) -> Mask:
    """The largest connected part of the cells that are more than `clear` (cells) from all others."""
    free = np.pad(~(grid.occupied | grid.unknown), 1)
    clearance = np.asarray(ndimage.distance_transform_edt(free))[1:-1, 1:-1]
    parts, count = ndimage.label(clearance > clear + 1.0)
    if not count:
        raise UsageError("the map has no free space for robots of this size: give a smaller --radius")
    room: Mask = parts == 1 + int(np.argmax(np.bincount(parts.ravel())[1:]))
    return room


def _places(
    grid: Occupancy, room: Mask, count: int, apart: float, draw: np.random.Generator
) -> list[Position]:
    cells, found = np.argwhere(room), list[Position]()
    for index in draw.integers(len(cells), size=_TRIES).tolist():
        row, column = cells[index].tolist()
        x, y = grid.place(column + 0.5, row + 0.5)
        if all(np.hypot(x - px, y - py) > apart for px, py in found):
            found.append((x, y))
            if len(found) == count:
                return found
    raise UsageError(f"the map has no room for {count} robots of this size")
