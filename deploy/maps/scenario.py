"""A scenario on a map: robots with random starts and goals in its free space."""

from __future__ import annotations

from os.path import relpath
from pathlib import Path

import numpy as np
from scipy import ndimage

from deploy.maps.expand import expanded
from deploy.maps.occupancy import Mask, Occupancy, read_map
from protocol.draws import Purpose, generator
from protocol.errors import UsageError
from protocol.scenario.file import parse_document
from protocol.scenario.model import FloorPlan, Point, Scenario
from protocol.scenario.tables import Document, read_table

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


def library_map(name: str, count: int, seed: int) -> Document:
    """`on_map` for a map of the library, with obstacles in place of the map."""
    folder = Path(__file__).parents[1] / "library" / "maps"
    document = on_map(folder / f"{name}.yaml", count, 0.2, seed)
    return expanded(document, folder, document["name"])


def _room(grid: Occupancy, clear: float) -> Mask:
    """The largest connected part of the cells that are more than `clear` (cells) from all others."""
    free = np.pad(~(grid.occupied | grid.unknown), 1)
    away = np.asarray(ndimage.distance_transform_edt(free))[1:-1, 1:-1]
    parts, count = ndimage.label(away > clear + 1.0)
    if not count:
        raise UsageError("the map has no free space for robots of this size: give a smaller --radius")
    room: Mask = parts == 1 + int(np.argmax(np.bincount(parts.ravel())[1:]))
    return room


def _places(grid: Occupancy, room: Mask, count: int, apart: float, draw: np.random.Generator) -> list[Point]:
    cells, found = np.argwhere(room), list[Point]()
    for index in draw.integers(len(cells), size=_TRIES).tolist():
        row, column = cells[index].tolist()
        x, y = grid.place(column + 0.5, row + 0.5)
        if all(np.hypot(x - px, y - py) > apart for px, py in found):
            found.append((x, y))
            if len(found) == count:
                return found
    raise UsageError(f"the map has no room for {count} robots of this size")
