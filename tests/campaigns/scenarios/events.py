"""Events of a run: process faults, and the orders of an operator."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from protocol.geometry import Shape
from protocol.scenario.checks import EVENTS
from protocol.scenario.model import Journey, Obstacle, Order, Position, ProcessFault, RobotSpec
from tests.campaigns.campaign import Dice
from tests.campaigns.scenarios.disturbances import Scale
from tests.campaigns.scenarios.places import anywhere, beside, one_obstacle

Event = Literal["kill", "pause", "resume", "restart"]
Step = tuple[int, Event]  # ticks since the story began, and what happens then

# what is mentioned twice is told twice as often
_STORIES = (
    *("late", "late", "restart", "restart", "again", "again", "killed"),
    *("back", "back", "frozen", "frozen", "replaced"),
)


def stories(dice: Dice, robots: Sequence[int], ticks: int, step: float) -> tuple[ProcessFault, ...]:
    """None to several stories of single robots, in a run of so many ticks of `step` seconds.

    late: killed at tick 0, and up again later; restart; again: several restarts; killed: for good;
    back: killed, and up again later; frozen: paused and resumed; replaced: paused, then restarted.
    """
    faults: list[ProcessFault] = []
    for _ in range(dice.pick((0, 0, 1, 1, 2, 2, 3, 4, 6))):
        robot, kind = dice.pick(robots), dice.pick(_STORIES)
        begin = 0 if kind == "late" else moment(dice, ticks, step, faults)
        faults += [
            ProcessFault(robot, (begin + after) * step, event) for after, event in _told(dice, kind, ticks)
        ]
    return sensible(faults)


def _told(dice: Dice, kind: str, ticks: int) -> list[Step]:
    """What happens to one robot, from when its story begins."""
    later = dice.pick((1, 2, dice.whole(1, 10), dice.whole(1, max(1, ticks // 2))))
    match kind:
        case "late" | "back":
            return [(0, "kill"), (later, "restart")]
        case "restart":
            return [(0, "restart")]
        case "again":
            pause = dice.pick((1, 2, 5, later))
            return [(n * pause, "restart") for n in range(dice.whole(2, 4))]
        case "killed":
            return [(0, "kill")]
        case "frozen":
            return [(0, "pause"), (later, "resume")]
        case _:
            return [(0, "pause"), (later, "restart")]


def moment(dice: Dice, ticks: int, step: float, events: Sequence[ProcessFault]) -> int:
    """A tick for something to happen: at the very start, near something else, or anywhere."""
    choice = dice.whole(0, 3)
    if choice == 0:
        return dice.pick((0, 0, 1, 2, 3))
    if choice == 1 and events:
        return max(0, round(dice.pick(events).at / step) + dice.whole(-3, 3))
    return dice.whole(0, max(1, (3 * ticks) // 4))


def sensible(faults: Iterable[ProcessFault]) -> tuple[ProcessFault, ...]:
    """Faults in the order of their times, without those that cannot happen to a process in its state then."""
    state: dict[int, str] = {}
    kept = []
    for fault in sorted(faults, key=lambda fault: fault.at):
        following = EVENTS[state.get(fault.robot, "running")].get(fault.event)
        if following is not None:
            state[fault.robot] = following
            kept.append(fault)
    return tuple(kept)


_ROBOTS = ("goal", "goal", "guest", "guest", "guest", "leaves", "comes back", "comes back", "meets")
_KINDS = (*_ROBOTS, "obstacle", "obstacle", "obstacle and away", "taken", "halt")
_GAPS = (1e-9, 1e-6, 1e-3, 0.3)  # of the radius, between the starts of a guest and of the robot beside it
_SOON = (0, 1, 1, 2, 3, 5, 10)  # ticks


@dataclass(frozen=True)
class Fleet:
    """What orders are about: robots, static obstacles, and the room."""

    robots: tuple[RobotSpec, ...]
    obstacles: tuple[Obstacle, ...]
    room: Shape

    @property
    def reach(self) -> float:
        return self.room.around.radius

    @property
    def centre(self) -> Position:
        """Of that disk, m."""
        return self.room.around.x, self.room.around.y


def orders(dice: Dice, scale: Scale, fleet: Fleet, faults: Sequence[ProcessFault]) -> tuple[Order, ...]:
    """None, or several; half of them near to something else that happens."""
    if not dice.chance(0.5):
        return ()
    asked: list[Order] = []
    for _ in range(dice.pick((1, 1, 2, 3, 4, 6))):
        times = [fault.at for fault in faults] + [order.at for order in asked]
        ticks = [round(at / scale.step) for at in times]
        begin = dice.whole(0, max(1, (3 * scale.ticks) // 4))
        if ticks and dice.chance(0.5):
            begin = max(0, dice.pick(ticks) + dice.whole(-2, 3))
        kind = dice.pick(_KINDS)
        told = (_of_robots if kind in _ROBOTS else _of_others)(dice, kind, fleet, tuple(asked))
        possible = ((after, order) for after, order in told if _is_inside(order, fleet.room))
        asked += [replace(order, at=(begin + after) * scale.step) for after, order in possible]
    obstacles = len(fleet.obstacles) + sum(order.place is not None for order in asked)
    asked = [order for order in asked if order.take is None or order.take <= obstacles]
    return tuple(sorted(asked, key=lambda order: order.at))


def _is_inside(order: Order, room: Shape) -> bool:
    points, radius = () if order.goal is None else order.goal.points, 0.0
    if order.add is not None:
        points, radius = (order.add.start, order.add.goal), order.add.radius
    if order.place is not None:
        around = order.place.shape.around
        points = ((around.x, around.y),)
    return all(room.distance(*point) + radius < 0.0 for point in points)


def _of_robots(dice: Dice, kind: str, fleet: Fleet, before: tuple[Order, ...]) -> Iterator[tuple[int, Order]]:
    """Ticks since it began, and what is asked of robots then."""
    known = [*fleet.robots, *(order.add for order in before if order.add is not None)]
    robot, later = dice.pick(known), dice.pick(_SOON)
    match kind:
        case "goal":
            yield 0, Order(0.0, goal=_journey(dice, fleet, robot))
        case "meets":  # all robots to one place
            point = _somewhere(dice, fleet)
            for each in known:
                yield later * dice.whole(0, 1), Order(0.0, goal=Journey(each.id, (point,)))
        case "guest":
            number = dice.pick((max(each.id for each in known) + 1, dice.whole(1, 30)))
            yield 0, Order(0.0, add=_guest(dice, fleet, robot, number))
        case "leaves":
            yield 0, Order(0.0, remove=robot.id)
            yield later, Order(0.0, goal=_journey(dice, fleet, robot))
        case "comes back":
            yield 0, Order(0.0, remove=robot.id)
            yield later, Order(0.0, add=_guest(dice, fleet, robot, robot.id))


def _of_others(dice: Dice, kind: str, fleet: Fleet, before: tuple[Order, ...]) -> Iterator[tuple[int, Order]]:
    """Ticks since it began, and what is asked of the other members, or of all, then."""
    later = dice.pick(_SOON)
    number = len(fleet.obstacles) + 1 + sum(order.place is not None for order in before)
    match kind:
        case "obstacle":
            yield 0, Order(0.0, place=one_obstacle(dice, fleet.robots, fleet.reach, fleet.centre))
        case "obstacle and away":
            yield 0, Order(0.0, place=one_obstacle(dice, fleet.robots, fleet.reach, fleet.centre))
            yield later, Order(0.0, take=dice.pick((number, dice.whole(1, number))))
        case "taken" if fleet.obstacles:
            yield 0, Order(0.0, take=dice.whole(1, len(fleet.obstacles)))
        case "halt":
            yield 0, Order(0.0, halt=True)
            yield later, dice.pick((Order(0.0, halt=False), Order(0.0, release=dice.whole(1, 2))))


def _journey(dice: Dice, fleet: Fleet, robot: RobotSpec) -> Journey:
    points = [_somewhere(dice, fleet) for _ in range(dice.pick((0, 1, 1, 1, 2, 3)))]
    if not points:
        return Journey(robot.id)
    return Journey(robot.id, tuple(points), queue=dice.chance(0.3), patrol=dice.chance(0.3))


def _guest(dice: Dice, fleet: Fleet, like: RobotSpec, number: int) -> RobotSpec:
    """A robot that is like another one but for where it begins and is to be, and at times its size."""
    start, radius = _somewhere(dice, fleet), like.radius * dice.pick((1.0, 1.0, 1.5))
    if dice.chance(0.4):
        start = beside(like.start, like.radius, start, radius, dice.pick(_GAPS) * radius)
    return replace(like, id=number, radius=radius, start=start, goal=_somewhere(dice, fleet))


def _somewhere(dice: Dice, fleet: Fleet) -> Position:
    robot = dice.pick(fleet.robots)
    return dice.pick((robot.start, robot.goal, anywhere(dice, 0.95 * fleet.reach, fleet.centre)))
