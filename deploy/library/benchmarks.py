"""Import of benchmark scenarios: db-CBS (YAML), LSC-DR (JSON), MovingAI (scen and map), SMGLib (XML).

The description of a scenario lists what could not be converted. A robot becomes the smallest known disk
around its shape, with the speed limit of its kind.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple
from xml.etree import ElementTree

import msgspec
import numpy as np
from msgspec import Meta

from deploy.maps.occupancy import Occupancy, as_map_error, converted, read_yaml
from deploy.maps.pieces import floor_plan, hull
from deploy.maps.scenario import map_scenario
from protocol.errors import UsageError
from protocol.scenario.file import parse_document
from protocol.scenario.model import Coordinate, Position, Scenario
from protocol.scenario.tables import Document

_LARGEST = 50_000_000  # bytes of a file
_SPACIOUS = 20.0  # time limit over the time of the straight way across
Dimension = Annotated[float, Meta(gt=0, le=1e6)]
Coordinates = Annotated[list[Coordinate], Meta(min_length=2)]
Extent = tuple[Coordinate, Coordinate]


class Options(NamedTuple):
    """Parameters that a file lacks."""

    robots: int = 5
    radius: float = 0.2  # of the robots, m
    seed: int = 0  # of all random values
    error: float = 0.05  # largest distance by which obstacles of a map may reach into free space, m
    obstacles: Path | None = None  # file of obstacles (LSC-DR)
    folder: Path = Path()  # of the scenario to write


def imported(file: Path, options: Options) -> Scenario:
    """The checked scenario of another tool's file.

    Raises:
        MapError: the file cannot be read, or does not have the format of its suffix.
        ScenarioError: it describes an invalid scenario.
        UsageError: the format is unknown, or has a property that no scenario can express.
    """
    if file.suffix in (".yaml", ".yml"):
        found = read_yaml(file)
        if isinstance(found, dict) and "image" in found:
            return map_scenario(
                file, options.robots, options.radius, options.seed, options.folder, options.error
            )
        return parse_document(_db_cbs(file, found), str(file))
    if file.suffix not in _FORMATS:
        raise UsageError(
            f"{file}: unknown suffix; known are .yaml (map_server, db-CBS), {', '.join(_FORMATS)}"
        )
    if file.stat().st_size > _LARGEST:
        raise as_map_error(file, "", f"is larger than {_LARGEST:,} bytes")
    return parse_document(_FORMATS[file.suffix](file, options), str(file))


def _document(
    file: Path,
    tool: str,
    robots: Iterable[tuple[float, Position, Position]],
    *,
    corners: tuple[Position, Position],
    obstacles: Iterable[Sequence[Position]],
    speed: float,
    left_out: Iterable[str],
) -> Document:
    """Document of robots (radius, start, goal) and polygons in the rectangle of two `corners`, m and m/s."""
    (left, low), (right, high) = corners
    lost = "; ".join(left_out)
    return {
        "name": file.stem,
        "description": f"From {file.name} ({tool})." + (f" Not taken over: {lost}." if lost else ""),
        "workspace": {"points": [[left, low], [right, low], [right, high], [left, high]]},
        "time": {
            "step": 0.1,
            "limit": float(math.ceil(_SPACIOUS * math.dist(*corners) / speed)),
            "tolerance": 0.05,
        },
        "control": {"speed": speed},
        "obstacles": [{"points": [list(map(float, point)) for point in each]} for each in obstacles],
        "robots": [
            {"id": n, "radius": radius, "start": list(start), "goal": list(goal)}
            for n, (radius, start, goal) in enumerate(robots, 1)
        ],
    }


class _Agent(msgspec.Struct):
    type: str
    start: Coordinates
    goal: Coordinates

    def robot(self, radius: float) -> tuple[float, Position, Position]:
        """Radius, start and goal, without heights or headings."""
        return radius, (self.start[0], self.start[1]), (self.goal[0], self.goal[1])


def _box(x: float, y: float, wide: float, high: float) -> list[Position]:
    u, v = 0.5 * wide, 0.5 * high
    return [(x - u, y - v), (x + u, y - v), (x + u, y + v), (x - u, y + v)]


# -- db-CBS: https://github.com/IMRCLab/db-CBS


class _CbsObstacle(msgspec.Struct):
    type: str
    center: Extent
    size: tuple[Dimension, Dimension]


class _CbsEnvironment(msgspec.Struct):
    min: Extent
    max: Extent
    obstacles: list[_CbsObstacle] = []


class _Cbs(msgspec.Struct):
    environment: _CbsEnvironment
    robots: Annotated[list[_Agent], Meta(min_length=1)]


_CAR = 0.5 * math.hypot(0.5, 0.25)  # m, around its rectangle
# Kind of robot -> radius (m), speed limit (m/s), and properties that a disk lacks
_KINDS = {
    "single_integrator": (0.1, 0.5, ""),
    "double_integrator": (0.15, 0.5, "limits of acceleration"),
    "unicycle_first_order": (_CAR, 0.5, "rectangles and headings"),
    "unicycle_first_order_sphere": (0.4, 0.5, "headings"),
    "unicycle_second_order": (_CAR, 0.5, "rectangles, headings and limits of acceleration"),
    "car_first_order": (_CAR, 0.5, "rectangles and headings"),
}


def _db_cbs(file: Path, found: Any) -> Document:
    instance = converted(file, found, _Cbs)
    kinds = []
    for n, robot in enumerate(instance.robots):
        kind = _KINDS.get(robot.type.replace("_0", ""))
        if kind is None:
            text = f"unknown kind {robot.type!r}; known are {', '.join(_KINDS)}"
            raise as_map_error(file, f"robots[{n}].type", text)
        kinds.append(kind)
    for n, each in enumerate(instance.environment.obstacles):
        if each.type != "box":
            raise as_map_error(
                file, f"environment.obstacles[{n}].type", f"{each.type!r} is not known: only box is"
            )
    return _document(
        file,
        "db-CBS",
        [robot.robot(radius) for robot, (radius, _, _) in zip(instance.robots, kinds, strict=True)],
        corners=(instance.environment.min, instance.environment.max),
        obstacles=[_box(*each.center, *each.size) for each in instance.environment.obstacles],
        speed=min(speed for _, speed, _ in kinds),
        left_out=sorted({lost for _, _, lost in kinds if lost}),
    )


# -- LSC-DR: https://github.com/qwerty35/lsc_dr_planner


class _Quadrotor(msgspec.Struct):
    max_vel: Annotated[list[Dimension], Meta(min_length=2)]
    radius: Dimension


class _World(msgspec.Struct):
    dimension: tuple[Coordinate, Coordinate, Coordinate, Coordinate, Coordinate, Coordinate]


class _Lsc(msgspec.Struct):
    quadrotors: dict[str, _Quadrotor]
    world: Annotated[list[_World], Meta(min_length=1)]
    agents: Annotated[list[_Agent], Meta(min_length=1)]
    obstacles: list[dict[str, Any]] = []


def _lsc(file: Path, options: Options) -> Document:
    try:
        instance = converted(file, json.loads(file.read_bytes()), _Lsc)
    except (ValueError, RecursionError) as error:
        raise as_map_error(file, "", f"is not JSON: {error}") from None
    lost = ["heights and limits of acceleration"]
    if instance.obstacles:
        lost.append(f"{len(instance.obstacles)} obstacles that move")
    for n, agent in enumerate(instance.agents):
        if agent.type not in instance.quadrotors:
            raise as_map_error(file, f"agents[{n}].type", f"{agent.type!r} is none of `quadrotors`")
    kinds = [instance.quadrotors[agent.type] for agent in instance.agents]
    x0, y0, _, x1, y1, _ = instance.world[0].dimension
    return _document(
        file,
        "LSC-DR",
        [agent.robot(kind.radius) for agent, kind in zip(instance.agents, kinds, strict=True)],
        corners=((x0, y0), (x1, y1)),
        obstacles=[] if options.obstacles is None else _columns(options.obstacles),
        speed=min(min(kind.max_vel[:2]) for kind in kinds),
        left_out=lost,
    )


def _columns(file: Path) -> list[list[Position]]:
    """Boxes of a world file, one per line: x, y, z of the centre and the sizes along them, m."""
    try:
        rows = [[float(each) for each in row] for row in csv.reader(_text(file).splitlines()) if row]
    except ValueError as error:
        raise as_map_error(file, "", f"is no table of numbers: {error}") from None
    for n, row in enumerate(rows, 1):
        if len(row) != 6 or not all(map(math.isfinite, row)) or min(row[3:5]) <= 0.0:
            raise as_map_error(file, f"line {n}", "must be x, y, z and three positive sizes")
    return [_box(row[0], row[1], row[3], row[4]) for row in rows]


# -- MovingAI: https://movingai.com/benchmarks


def _moving_ai(file: Path, options: Options) -> Document:
    lines = [line.split() for line in _text(file).splitlines() if line.strip()]
    if not lines or lines[0][0] != "version":
        raise as_map_error(file, "line 1", "must be `version 1`")
    rows = [(n, row) for n, row in enumerate(lines[1:], 2)]
    try:
        ways = [(int(row[4]), int(row[5]), int(row[6]), int(row[7])) for _, row in rows]
        name = Path(rows[0][1][1]).name
    except (IndexError, ValueError):
        raise as_map_error(
            file, "", "must have nine columns: bucket, map, sizes, start, goal, length"
        ) from None
    grid = _octile(file.parent / name)
    chosen: list[tuple[int, int, int, int]] = []
    for way in ways:  # no two robots may share a start or a goal
        if all(way[:2] != other[:2] and way[2:] != other[2:] for other in chosen):
            chosen.append(way)
        if len(chosen) == options.robots:
            break
    else:
        raise UsageError(f"{file} has only {len(chosen)} compatible starts and goals, not {options.robots}")
    height = grid.occupied.shape[0]
    plan = floor_plan(grid, 0.0, options.radius)
    if not plan.workspace:
        raise UsageError(f"{file.parent / name} has no free space for a radius of {options.radius:g} m")
    xs, ys = zip(*plan.workspace, strict=True)
    return _document(
        file,
        "MovingAI",
        [
            (options.radius, (sx + 0.5, height - sy - 0.5), (gx + 0.5, height - gy - 0.5))
            for sx, sy, gx, gy in chosen
        ],
        corners=((min(xs), min(ys)), (max(xs), max(ys))),
        obstacles=plan.obstacles,
        speed=1.0,
        left_out=["costs of terrain: swamp and water are obstacles"],
    )


def _octile(file: Path) -> Occupancy:
    """A map with cells of 1 m, of which only `.` and `G` are free."""
    lines = _text(file).splitlines()
    head = dict(line.split(maxsplit=1) for line in lines[:3] if len(line.split()) == 2)
    rows = lines[4:]
    try:
        height, width = int(head["height"]), int(head["width"])
    except (KeyError, ValueError):
        raise as_map_error(file, "", "must begin with `type`, `height` and `width`") from None
    if len(rows) < height or {len(row) for row in rows[:height]} != {width}:
        raise as_map_error(file, "", f"must have {height} rows of {width} cells")
    free = np.array([[cell in ".G" for cell in row] for row in reversed(rows[:height])])
    return Occupancy(~free, np.zeros_like(free), 1.0)


def _text(file: Path) -> str:
    try:
        return file.read_text("ascii")
    except OSError as error:
        raise as_map_error(file, "", f"cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise as_map_error(file, "", "is not ASCII text") from None


# -- SMGLib: doorway, hallway and intersection of its Social-ORCA


def _smglib(file: Path, _: Options) -> Document:
    try:
        root = ElementTree.fromstring(file.read_bytes())
    except ElementTree.ParseError as error:
        raise as_map_error(file, "", f"is not XML: {error}") from None

    def number(element: ElementTree.Element | None, key: str) -> float:
        text = "" if element is None else element.get(key, "") or (element.findtext(key) or "")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            where = "root" if element is None else element.tag
            raise as_map_error(file, f"{where}.{key}", f"must be a number, is {text!r}")
        return value

    plain, map_ = root.find("agents/default_parameters"), root.find("map")
    cell, radius = number(map_, "cellsize"), number(plain, "size")
    robots = [
        (
            radius,
            (number(agent, "start.xr"), number(agent, "start.yr")),
            (number(agent, "goal.xr"), number(agent, "goal.yr")),
        )
        for agent in root.iterfind("agents/agent")
    ]
    walls = [
        hull([(number(corner, "xr"), number(corner, "yr")) for corner in each.iterfind("vertex")])
        for each in root.iterfind("obstacles/obstacle")
    ]
    if any("1" in (row.text or "") for row in root.iterfind("map/grid/row")):
        raise as_map_error(file, "map.grid", "has blocked cells; only `obstacles` are taken over")
    return _document(
        file,
        "SMGLib",
        robots,
        corners=((0.0, 0.0), (cell * number(map_, "width"), cell * number(map_, "height"))),
        obstacles=walls,
        speed=number(plain, "movespeed"),
        left_out=["parameters of ORCA"],
    )


_FORMATS: dict[str, Callable[[Path, Options], Document]] = {
    ".json": _lsc,
    ".scen": _moving_ai,
    ".xml": _smglib,
}
