"""Where disks stand: anywhere, or closer together than chance would put them."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from agents.lines import own_set
from deploy.library.instances import random_starts
from protocol.errors import UsageError
from protocol.geometry import Disk, Shape
from protocol.scenario.model import Carrying, Obstacle, Part, Position, RobotSpec, Scenario, Workspace
from tests.campaigns.campaign import Dice

_BETWEEN = (0.0, 0.0, 1e-9, 1e-6, 1e-3, 0.03)  # in radii; 0: the next number of the computer
_WHISKER = 1e-15  # by which an exact touch is left, at first
_OBSTACLES = 30  # attempts
_BESIDE = (1e-6, 1e-3, 0.3)  # of the radius, between a robot and the obstacle beside which it begins
_WALL_GAPS = (1e-9, 1e-6, 1e-3, 0.1)  # of the workspace's radius, between robots and straight walls
_PARTS = 12  # attempts
_MOST = 3  # parts
_SMALLEST = 0.16  # of the room, the smallest robot among which parts are drawn: ways are planned on a grid
_REACHED = (0.0, 1e-6, 0.1, 0.5, 1.0)  # of the reach, between a part and its neighbour


def scattered(dice: Dice, radii: Sequence[float], workspace: float) -> list[Position] | None:
    """Centres of disks in a workspace of this radius, all lengths in m; None if they found no room."""
    try:
        drawn = random_starts([radius / workspace for radius in radii], 1.0, dice.whole(0, 2**16))
    except UsageError:
        return None
    return [(workspace * x, workspace * y) for x, y in drawn]


def fits(i: int, points: Sequence[Position], radii: Sequence[float], workspace: float) -> bool:
    """Whether disk i touches neither boundary nor another disk, computed as the scenario's checks do."""
    x, y = points[i]
    return math.hypot(x, y) + radii[i] < workspace and all(
        math.hypot(x - points[j][0], y - points[j][1]) > radii[i] + radii[j]
        for j in range(len(radii))
        if j != i
    )


def drawn_together(
    dice: Dice, points: Sequence[Position], radii: Sequence[float], workspace: float, times: int
) -> list[Position]:
    """The same disks with some of them, `times` at most, moved against another one or the boundary."""
    points = list(points)
    for _ in range(times):
        i, j = dice.whole(0, len(points) - 1), dice.whole(0, len(points) - 1)
        gap = dice.pick(_BETWEEN) * radii[i]
        moved = (
            at_the_wall(points[i], radii[i], workspace, gap)
            if i == j
            else beside(points[j], radii[j], points[i], radii[i], gap)
        )
        before, points[i] = points[i], moved
        if not fits(i, points, radii, workspace):
            points[i] = before
    return points


def at_the_wall(point: Position, radius: float, workspace: float, gap: float) -> Position:
    """The point in the same direction at which a disk has this gap to the boundary, and surely some."""
    length, angle = workspace - radius - gap, math.atan2(point[1], point[0])
    return _surely(
        lambda whisker: polar((0.0, 0.0), length * (1.0 - whisker), angle),
        lambda at: math.hypot(*at) + radius < workspace,
    )


def beside(other: Position, other_radius: float, point: Position, radius: float, gap: float) -> Position:
    """The point in the same direction from `other` at which two disks have this gap, and surely some."""
    apart, angle = other_radius + radius, math.atan2(point[1] - other[1], point[0] - other[0])
    return _surely(
        lambda whisker: polar(other, (apart + gap) * (1.0 + whisker), angle),
        lambda at: math.hypot(at[0] - other[0], at[1] - other[1]) > apart,
    )


def _surely(place: Callable[[float], Position], is_clear: Callable[[Position], bool]) -> Position:
    """The place nearest to an exact touch that the computer takes for clear."""
    whisker = _WHISKER
    while not is_clear(at := place(whisker)):
        whisker *= 2.0
    return at


def polar(centre: Position, length: float, angle: float) -> Position:
    return centre[0] + length * math.cos(angle), centre[1] + length * math.sin(angle)


def anywhere(dice: Dice, reach: float, centre: Position = (0.0, 0.0)) -> Position:
    return polar(centre, reach * math.sqrt(dice.uniform(0.0, 1.0)), dice.uniform(-math.pi, math.pi))


def around(dice: Dice, workspace: Workspace, robots: Sequence[RobotSpec]) -> Workspace:
    """The same round workspace, or a polygon: around it, or as close around all robots as walls can stand."""
    if dice.chance(0.65):
        return workspace
    if dice.chance(0.3):
        return Workspace(points=_regular(dice, workspace.disk_radius))
    gap, left = workspace.disk_radius * dice.pick(_WALL_GAPS), own_set.around(4.0 * workspace.disk_radius)
    for nx, ny in _walls(dice):
        reached = [nx * x + ny * y + each.radius for each in robots for x, y in (each.start, each.goal)]
        left = left and left.cut(nx, ny, max(reached) + gap)
    return workspace if left is None else Workspace(points=tuple(zip(left.xs, left.ys, strict=True)))


def _regular(dice: Dice, radius: float) -> tuple[Position, ...]:
    """Corners of a regular polygon around the workspace."""
    sides, turn = dice.whole(3, 8), dice.uniform(0.0, math.tau)
    reach = radius / math.cos(math.pi / sides)
    return tuple(polar((0.0, 0.0), reach, turn + math.tau * side / sides) for side in range(sides))


def _walls(dice: Dice) -> list[Position]:
    """Outward normals of three to seven walls; some rooms have acute corners, some are narrow."""
    turn = dice.uniform(0.0, math.tau)
    angles = [math.tau * dice.uniform(0.0, 1.0) for _ in range(dice.whole(0, 4))]
    angles += [turn, turn + dice.uniform(1.6, 3.1), turn + dice.uniform(3.2, 4.6)]
    return [polar((0.0, 0.0), 1.0, angle) for angle in angles]


def obstacles(dice: Dice, robots: Sequence[RobotSpec], workspace: float, room: Shape) -> tuple[Obstacle, ...]:
    """None in most scenarios; else a few disks and polygons that cover no start and no goal.

    Half of them stand right beside a robot. `workspace` is its radius, m.
    """
    if not dice.chance(0.35):
        return ()
    drawn = [one_obstacle(dice, robots, workspace, (0.0, 0.0)) for _ in range(_OBSTACLES)]
    clear = [
        obstacle
        for obstacle in drawn
        if room.distance(obstacle.shape.around.x, obstacle.shape.around.y) < 0.0
        and all(
            obstacle.shape.distance(*point) > robot.radius
            for robot in robots
            for point in (robot.start, robot.goal)
        )
    ]
    return tuple(clear[: dice.whole(1, 5)])


def one_obstacle(dice: Dice, robots: Sequence[RobotSpec], workspace: float, centre: Position) -> Obstacle:
    """A disk or a polygon, half of the time right beside where a robot begins.

    Args:
        workspace, centre: of a disk in which the middle is, m.
    """
    size = workspace * dice.log_uniform(0.005, 0.3)
    angle, turn = dice.uniform(0.0, math.tau), dice.uniform(0.0, math.tau)
    if dice.chance(0.5):
        robot = dice.pick(robots)
        middle = polar(robot.start, size + robot.radius * (1.0 + dice.pick(_BESIDE)), angle)
    else:
        middle = anywhere(dice, workspace, centre)
    if dice.chance(0.4):
        return Obstacle(center=middle, radius=size)
    return Obstacle(points=_polygon(dice, middle, size, turn))


def _polygon(dice: Dice, centre: Position, size: float, turn: float) -> tuple[Position, ...]:
    """Corners on an ellipse, one of which is `turn` away from its long axis."""
    corners, flat = dice.pick((3, 4, 4, 5, 8)), dice.pick((1.0, dice.log_uniform(0.02, 1.0)))
    cos, sin = math.cos(turn), math.sin(turn)
    points = []
    for corner in range(corners):
        u = size * math.cos(math.tau * corner / corners)
        v = size * flat * math.sin(math.tau * corner / corners)
        points.append((centre[0] + cos * u - sin * v, centre[1] + sin * u + cos * v))
    return tuple(points)


def loads(
    dice: Dice, robots: Sequence[RobotSpec], standing: Iterable[Obstacle], room: Shape
) -> tuple[tuple[Part, ...], Carrying]:
    """None in most scenarios; else a few, many of them larger than robots, and how far these reach."""
    smallest = min(robot.radius for robot in robots)
    if not dice.chance(0.4) or smallest < _SMALLEST * room.around.radius:
        return (), Carrying()
    carrying = Carrying(smallest * dice.pick((0.1, 0.3, dice.log_uniform(0.03, 2.0))))
    obstacles = [obstacle.shape for obstacle in standing]
    starts: list[Shape] = [*obstacles, *(Disk(*robot.start, robot.radius) for robot in robots)]
    goals: list[Shape] = [*obstacles, *(Disk(*robot.goal, robot.radius) for robot in robots)]
    alike, found = dice.chance(0.5), list[Part]()
    for _ in range(_PARTS):
        radius = found[0].radius if alike and found else smallest * dice.log_uniform(0.7, 2.5)
        start = _start(dice, robots, found, radius, carrying.reach, room)
        goal = _goal(dice, start, radius, smallest, room)
        if _is_free(start, radius, starts, room) and _is_free(goal, radius, goals, room):
            found.append(Part(radius, start, goal))
            starts.append(Disk(*start, radius))
            goals.append(Disk(*goal, radius))
    return tuple(found[: dice.whole(1, _MOST)]), carrying


def by_points(scenario: Scenario) -> Scenario:
    """Where there are parts, robots that are points and receive all States: others cannot carry them."""
    if not scenario.parts:
        return scenario
    robots = tuple(replace(robot, body=None) for robot in scenario.robots)
    return replace(scenario, robots=robots, body="point", network=replace(scenario.network, interest="all"))


def _start(
    dice: Dice, robots: Sequence[RobotSpec], parts: Sequence[Part], radius: float, reach: float, room: Shape
) -> Position:
    point = _somewhere(dice, room)
    if dice.chance(0.2):
        return point
    others: list[RobotSpec | Part] = [*robots, *parts]
    other = dice.pick(others)
    return beside(other.start, other.radius, point, radius, reach * dice.pick(_REACHED))


def _goal(dice: Dice, start: Position, radius: float, unit: float, room: Shape) -> Position:
    """Not far off, or anywhere."""
    if dice.chance(0.3):
        return _somewhere(dice, room)
    angle, away = dice.uniform(0.0, math.tau), radius + unit * dice.uniform(0.0, 4.0)
    return polar(start, away, angle)


def _somewhere(dice: Dice, room: Shape) -> Position:
    return anywhere(dice, room.around.radius, (room.around.x, room.around.y))


def _is_free(point: Position, radius: float, others: Iterable[Shape], room: Shape) -> bool:
    inside = room.distance(*point) + radius < 0.0
    return inside and all(shape.distance(*point) > radius for shape in others)
