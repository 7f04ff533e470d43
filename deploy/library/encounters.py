"""Robots that change places, and robots among obstacles: benchmarks of other authors, and variants.

Symmetric starts lie exactly on a saddle of the navigation function.
"""

from __future__ import annotations

import math
from itertools import repeat

import numpy as np

from deploy.library.instances import numbered
from protocol.draws import Purpose, generator
from protocol.errors import UsageError
from protocol.scenario.body import PRESETS
from protocol.scenario.model import Control, Obstacle, Position, RobotSpec, Scenario, Time, Workspace

RADIUS = 0.03  # m
CIRCLE = 0.40  # m, of the starts
SPACING = 0.10  # m, least distance between neighbours; many robots enlarge the circle
MARGIN = 0.05  # m, from the circle to the boundary
LARGEST_JITTER = 0.015  # m; starts cannot overlap or leave the workspace


def swap(count: int, jitter: float = 0.0, seed: int = 0) -> Scenario:
    """Robots on a circle, each with the opposite point as goal.

    Args:
        jitter: largest displacement of a start, m, which takes the fleet off the saddle.

    Raises:
        UsageError: `jitter` is out of range.
    """
    if not 0.0 <= jitter <= LARGEST_JITTER:
        raise UsageError(f"jitter {jitter:g}: choose between 0 and {LARGEST_JITTER} m")
    circle = max(CIRCLE, SPACING / (2.0 * math.sin(math.pi / count)))
    robots = _opposite(_circle(count, circle), RADIUS, jitter, seed)
    text = f"{count} robots on a circle change places" + (
        f", starts off by up to {jitter:g} m" if jitter else ""
    )
    return Scenario(robots, f"swap-{count}", text, seed, Workspace(circle + MARGIN))


def circle(count: int, jitter: float = 0.0, seed: int = 0) -> Scenario:
    """RVO2's Circle: robots of radius 1.5 m on a circle of 200 m change places at 2 m/s, with a tolerance of
    1.5 m.

    Args:
        jitter: largest displacement of a start, m.
    """
    return Scenario(
        _opposite(_circle(count, 200.0), 1.5, jitter, seed),
        f"circle-{count}",
        f"{count} robots on a circle of 200 m change places; sizes as in RVO2",
        seed,
        Workspace(220.0),
        Time(step=0.25, limit=800.0, tolerance=1.5),
        Control(speed=2.0),
    )


def turtlebots(count: int, seed: int = 0) -> Scenario:
    """TurtleBots on a circle, each with the opposite point as goal, in random headings."""
    body = PRESETS["turtlebot3-burger"]
    radius = body.disk or 0.0
    circle = max(4.0 * radius, (2.0 * radius + SPACING) / (2.0 * math.sin(math.pi / count)))
    draws = generator(seed, Purpose.SCENARIO).uniform(-math.pi, math.pi, size=count).tolist()
    robots = tuple(
        RobotSpec(n + 1, radius, (x, y), (0.0 - x, 0.0 - y), round(draws[n], 6))
        for n, (x, y) in enumerate(_circle(count, circle))
    )
    return Scenario(
        robots,
        f"turtlebots-{count}",
        f"{count} robots on two wheels each change places on a circle",
        seed,
        Workspace(round(circle + radius + 2.0 * SPACING, 6)),
        Time(limit=300.0, tolerance=0.02),
        body="turtlebot3-burger",
    )


def _opposite(
    places: list[Position], radius: float, jitter: float = 0.0, seed: int = 0
) -> tuple[RobotSpec, ...]:
    draws = generator(seed, Purpose.SCENARIO).uniform(size=(len(places), 2))
    robots = []
    for n, (x, y) in enumerate(places):
        reach, angle = jitter * math.sqrt(draws[n, 0]), math.tau * draws[n, 1]
        start = (x + reach * math.cos(angle), y + reach * math.sin(angle))
        robots.append(RobotSpec(n + 1, radius, start, (0.0 - x, 0.0 - y)))
    return tuple(robots)


def _circle(count: int, radius: float) -> list[Position]:
    angles = [math.tau * n / count for n in range(count // 2 if count % 2 == 0 else count)]
    points = [(round(radius * math.cos(a), 12) + 0.0, round(radius * math.sin(a), 12) + 0.0) for a in angles]
    return points if count % 2 else points + [(0.0 - x, 0.0 - y) for x, y in points]


# -- among obstacles

_TRIES = 20_000  # random places tried in all
_Corners = tuple[Position, ...]


def forest(count: int, seed: int = 0) -> Scenario:
    """40 boxes of 0.5 m in 10 m by 10 m; robots of 0.15 m change places on a circle of 4 m (LSC-DR)."""
    robots = _opposite(_circle(count, 4.0), 0.15)
    random = generator(seed, Purpose.SCENARIO)
    keep = [(point, spec.radius + 0.05) for spec in robots for point in (spec.start, spec.goal)]
    boxes = _scattered(random, keep, many=40, reach=4.5, sides=(0.5, 0.5), turned=False)
    return Scenario(
        robots,
        f"forest-{count}",
        f"{count} robots change places among 40 boxes; starts as in LSC-DR's forest10",
        seed,
        Workspace(points=_box((0.0, 0.0), 5.0, 5.0)),
        Time(step=0.2, limit=120.0, tolerance=0.1),
        Control(speed=1.0),
        obstacles=boxes,
    )


def boxes(count: int, seed: int = 0) -> Scenario:
    """8 boxes in 4 m by 4 m; robots of 0.05 m, starts and goals 0.2 m apart (GCBF+, SingleIntegrator)."""
    random = generator(seed, Purpose.SCENARIO)
    obstacles = _scattered(random, (), many=8, reach=1.8, sides=(0.1, 0.5), turned=True)
    starts, goals = (_free_places(random, obstacles, count) for _ in range(2))
    return Scenario(
        numbered(repeat(0.05), starts, goals),
        f"boxes-{count}",
        f"{count} robots with random goals among 8 boxes, sizes as in GCBF+",
        seed,
        Workspace(points=_box((0.0, 0.0), 2.0, 2.0)),
        Time(step=0.03, limit=60.0, tolerance=0.1),
        Control(speed=1.0),
        obstacles=obstacles,
    )


def blocks(count: int, seed: int = 0) -> Scenario:
    """Four groups cross between four square blocks (RVO2, Blocks: 25 each); here each robot has its own goal.
    Raises UsageError if `count` is not a multiple of 4.
    """
    if count % 4:
        raise UsageError(f"{count} robots are not four groups: choose a multiple of 4")
    robots = []
    for n in range(count):
        group, member = divmod(n, count // 4)
        i, j = 55.0 + 10.0 * (member % 5), 55.0 + 10.0 * (member // 5)
        x, y = (i, j, -i, -j)[group], (j, -i, -j, i)[group]
        robots.append(RobotSpec(n + 1, 2.0, (x, y), (-x, -y)))
    corners = [(sx * 25.0, sy * 25.0) for sx in (1, -1) for sy in (1, -1)]
    return Scenario(
        tuple(robots),
        f"blocks-{count}",
        f"four groups of {count // 4} robots cross between four blocks; sizes as in RVO2",
        seed,
        Workspace(points=_box((0.0, 0.0), 110.0, 110.0)),
        Time(step=0.25, limit=600.0, tolerance=1.0),
        Control(speed=2.0),
        obstacles=tuple(Obstacle(points=_box(centre, 15.0, 15.0)) for centre in corners),
    )


def beads(count: int, seed: int = 0) -> Scenario:
    """Robots on a line segment, where none can pass another (Koditschek, beads on a line)."""
    random = generator(seed, Purpose.SCENARIO)
    radius, length = 0.02, 0.06 * count
    starts, goals = (_spaced(random, count, 2.2 * radius, length) for _ in range(2))
    robots = tuple(RobotSpec(n + 1, radius, (starts[n], 0.0), (goals[n], 0.0)) for n in range(count))
    return Scenario(
        robots,
        f"beads-{count}",
        f"{count} robots in a corridor, which keep their order",
        seed,
        Workspace(points=_box((0.0, 0.0), length + 2.0 * radius, 1.5 * radius)),
    )


def _box(centre: Position, ahead: float, aside: float, turn: float = 0.0) -> _Corners:
    cos, sin = math.cos(turn), math.sin(turn)
    corners = ((ahead, aside), (-ahead, aside), (-ahead, -aside), (ahead, -aside))
    return tuple((centre[0] + cos * u - sin * v, centre[1] + sin * u + cos * v) for u, v in corners)


def _scattered(
    random: np.random.Generator,
    keep: list[tuple[Position, float]] | tuple[()],
    *,
    many: int,
    reach: float,
    sides: tuple[float, float],
    turned: bool,
) -> tuple[Obstacle, ...]:
    """Random boxes clear of the places `keep` (point, radius); they may overlap each other."""
    found: list[Obstacle] = []
    for _ in range(_TRIES):
        x, y, along, across, turn = map(float, random.random(5))
        ahead, aside = (0.5 * (sides[0] + part * (sides[1] - sides[0])) for part in (along, across))
        centre = ((2.0 * x - 1.0) * reach, (2.0 * y - 1.0) * reach)
        obstacle = Obstacle(points=_box(centre, ahead, aside, math.tau * turn if turned else 0.0))
        if all(obstacle.shape.distance(*point) > room for point, room in keep):
            found.append(obstacle)
            if len(found) == many:
                return tuple(found)
    raise UsageError(f"no room for {many} boxes")


def _free_places(random: np.random.Generator, obstacles: tuple[Obstacle, ...], count: int) -> list[Position]:
    """Centres at least 0.2 m apart and 0.1 m from every obstacle and wall."""
    shapes, places = [obstacle.shape for obstacle in obstacles], list[Position]()
    for _ in range(_TRIES):
        x, y = (float(part) for part in 3.8 * random.random(2) - 1.9)
        apart = all(math.dist((x, y), other) > 0.2 for other in places)
        if apart and all(shape.distance(x, y) > 0.1 for shape in shapes):
            places.append((x, y))
            if len(places) == count:
                return places
    raise UsageError(f"no room for {count} robots")


def _spaced(random: np.random.Generator, count: int, apart: float, length: float) -> list[float]:
    """Increasing random numbers within `length` of 0, at least `apart` from each other, m."""
    room = 2.0 * length - (count - 1) * apart
    return [float(part) - length + n * apart for n, part in enumerate(sorted(room * random.random(count)))]
