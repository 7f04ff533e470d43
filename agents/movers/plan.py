"""Which parts can be brought to their goals one after another, and how one is brought.

A part is fetched by a disk that gets beside it, and carried by the larger disk that both are together; it is
put down from beside its goal. What stands, other parts among it, is in the way of both; robots are not: they
give way. An order is looked for in which every part finds its way once those before it are at their goals.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from agents.movers.floor import Grid, Reals
from protocol.geometry import Disk, Shape
from protocol.scenario.model import Part, Scenario

Vector = tuple[float, float]

CELLS: Final = 4.0  # to the smallest radius
DIRECTIONS: Final = 32  # from which a part is tried
MARGIN: Final = 0.1  # of the reach, by which places beside parts keep clear of all else
_OTHER: Final = 7  # places on from one attempt to the next
_TRIES: Final = 60  # spare places that are looked at
_MOST: Final = 400  # states of the floor that a search for an order looks at


@dataclass(frozen=True)
class Errand:
    """How one part is brought to its goal.

    Attributes:
        fetch, deliver: where the carrier stands to take it up, and to put it down, m.
        cost: length of the way to `fetch`, m.
    """

    part: int
    fetch: Vector
    deliver: Vector
    cost: float


class Planner:
    """Plans for robots of one radius.

    Args:
        scenario: with the radii of robots that carry nothing.
        radius: of a robot that carries nothing, m.

    Attributes:
        grid: the cells that ways are looked for on.
    """

    def __init__(self, scenario: Scenario, radius: float) -> None:
        self._parts: dict[int, Part] = dict(enumerate(scenario.parts, 1))
        self._things = [thing.shape for thing in scenario.things]
        self._radius, self._reach = radius, scenario.carrying.reach
        smallest = min([radius, *(part.radius for part in scenario.parts)])
        self.grid = Grid(scenario.workspace.shape, smallest / CELLS)
        self._homes = [Disk(*robot.goal, robot.radius) for robot in scenario.robots]
        self._dead: set[tuple[tuple[int, Vector], ...]] = set()  # parts that cannot all get to their goals

    def loaded(self, part: int) -> float:
        """Radius of the disk that a robot is with a part, m."""
        return max(self._radius, self._parts[part].radius)

    def errands(self, position: Vector, floor: Mapping[int, Vector], others: list[Shape]) -> list[Errand]:
        """Parts that can be brought to their goals as all stands, the nearest first.

        Args:
            position: of the robot, m.
            floor: where parts stand, m; those at their goals, too.
            others: what else stands beside things of the scenario.
        """
        disks, fixed, far = self._survey(position, floor, others)
        found = [
            errand
            for part in floor
            if not self._is_home(part, floor[part])
            and (errand := self._errand(part, disks, fixed, far)) is not None
        ]
        return sorted(found, key=lambda errand: (errand.cost, errand.part))

    def errand(
        self, part: int, position: Vector, floor: Mapping[int, Vector], others: list[Shape]
    ) -> Errand | None:
        """How one part that stands is brought to its goal; arguments as of `errands`."""
        return self._errand(part, *self._survey(position, floor, others))

    def _survey(
        self, position: Vector, floor: Mapping[int, Vector], others: list[Shape]
    ) -> tuple[dict[int, Disk], list[Shape], Reals]:
        """Parts, what else stands, and how far it is to everywhere."""
        disks = {part: Disk(*at, self._parts[part].radius) for part, at in floor.items()}
        fixed = [*self._things, *others]
        free = self.grid.clear([*fixed, *disks.values()], self._radius)
        return disks, fixed, self.grid.ways(free, [position])

    def delivery(
        self,
        part: int,
        target: Vector,
        position: Vector,
        floor: Mapping[int, Vector],
        others: list[Shape],
        attempt: int = 0,
    ) -> Vector | None:
        """From where to put a part down at `target` that is carried from a position, m; None if there is no
        way. The nearest place at the first attempt, others at later ones."""
        shapes, carried = self._standing(part, floor, others), self.loaded(part)
        if any(shape.distance(*target) < self._parts[part].radius for shape in shapes):
            return None
        far = self.grid.ways(self.grid.clear(shapes, carried), [position])
        places = self._beside(target, self._parts[part].radius, carried, shapes)
        found = self._by_way(places, far)
        return found[attempt * _OTHER % len(found)] if found else None

    def refuge(
        self, part: int, position: Vector, floor: Mapping[int, Vector], others: list[Shape]
    ) -> Vector | None:
        """The place farthest from its goal to which a part can be carried, m; None if it cannot be moved."""
        free = self.grid.clear(self._standing(part, floor, others), self.loaded(part))
        far = self.grid.ways(free, [position])
        goal = self._parts[part].goal
        cells = [(float(self.grid.x[c]), float(self.grid.y[c])) for c in zip(*free.nonzero(), strict=True)]
        reached = [cell for cell in cells if math.isfinite(self.grid.way(far, cell))]
        return max(reached, key=lambda cell: (math.dist(cell, goal), cell), default=None)

    def spare(
        self, part: int, position: Vector, floor: Mapping[int, Vector], others: list[Shape]
    ) -> Vector | None:
        """A place near by where a part that is carried is in nobody's place, m; None if there is none."""
        shapes, radius = self._standing(part, floor, others), self._parts[part].radius
        goals = [Disk(*spec.goal, spec.radius) for each, spec in self._parts.items() if each != part]
        free = self.grid.clear([*shapes, *goals, *self._homes], radius + MARGIN * self._reach)
        cells = [(float(self.grid.x[c]), float(self.grid.y[c])) for c in zip(*free.nonzero(), strict=True)]
        cells.sort(key=lambda cell: (math.dist(cell, position), cell))
        far = self.grid.ways(self.grid.clear(shapes, self.loaded(part)), [position])
        for cell in cells[:: max(1, len(cells) // _TRIES)]:
            if self._best(self._beside(cell, radius, self.loaded(part), shapes), far) is not None:
                return cell
        return None

    def clearing(self, position: Vector, floor: Mapping[int, Vector], others: list[Shape]) -> Errand | None:
        """A part that stands in another's place and can be taken up; where to bring it is decided then."""
        disks, fixed, far = self._survey(position, floor, others)
        for part, disk in disks.items():
            goals = [spec.goal for each, spec in self._parts.items() if each != part]
            sizes = [spec.radius for each, spec in self._parts.items() if each != part]
            bars = any(disk.distance(*goal) < size for goal, size in zip(goals, sizes, strict=True))
            if self._is_home(part, floor[part]) or not bars:
                continue
            rest = [*fixed, *(other for each, other in disks.items() if each != part)]
            places = self._beside((disk.x, disk.y), disk.radius, self._radius, rest)
            fetch = self._best((p for p in places if self._clear(p, rest, self.loaded(part))), far)
            if fetch is not None and self.spare(part, fetch, _without(floor, part), others) is not None:
                return Errand(part, fetch, fetch, self.grid.way(far, fetch))
        return None

    def _standing(self, part: int, floor: Mapping[int, Vector], others: list[Shape]) -> list[Shape]:
        """All that stands but one part."""
        disks = [Disk(*at, self._parts[each].radius) for each, at in floor.items() if each != part]
        return [*self._things, *others, *disks]

    def beside(self, position: Vector, held: Disk, grown: float, rest: list[Shape]) -> Vector | None:
        """Where to take a part up that is on a robot, as a disk that becomes `grown` there, m; None if there
        is no way."""
        far = self.grid.ways(self.grid.clear([*rest, held], self._radius), [position])
        places = self._beside((held.x, held.y), held.radius, self._radius, rest)
        return self._best((point for point in places if self._clear(point, rest, grown)), far)

    def leads_on(self, errand: Errand, floor: Mapping[int, Vector], others: list[Shape]) -> bool:
        """Whether all parts can still get to their goals once this one is there."""
        after = {**floor, errand.part: self._parts[errand.part].goal}
        budget = [_MOST]
        return self._solvable(after, errand.deliver, others, budget)

    def solvable(self, floor: Mapping[int, Vector], position: Vector, others: list[Shape]) -> bool:
        """Whether there is an order in which all parts get to their goals."""
        return self._solvable(dict(floor), position, others, [_MOST])

    def _solvable(
        self, floor: dict[int, Vector], position: Vector, others: list[Shape], budget: list[int]
    ) -> bool:
        left = tuple((part, at) for part, at in sorted(floor.items()) if not self._is_home(part, at))
        if not left:
            return True
        if budget[0] <= 0 or (not others and left in self._dead):
            return False
        budget[0] -= 1
        for errand in self.errands(position, floor, others):
            after = {**floor, errand.part: self._parts[errand.part].goal}
            if self._solvable(after, errand.deliver, others, budget):
                return True
        if not others:
            self._dead.add(left)
        return False

    def _is_home(self, part: int, at: Vector) -> bool:
        return math.dist(at, self._parts[part].goal) < 1e-9

    def _errand(self, part: int, disks: Mapping[int, Disk], fixed: list[Shape], far: Reals) -> Errand | None:
        spec, carried = self._parts[part], self.loaded(part)
        rest: list[Shape] = [*fixed, *(disk for each, disk in disks.items() if each != part)]
        if any(shape.distance(*spec.goal) < spec.radius for shape in rest):
            return None
        ends = list(self._beside(spec.goal, spec.radius, carried, rest))
        if not ends:
            return None
        open_ = self.grid.clear(rest, carried)
        back = self.grid.ways(open_, ends)
        held = disks[part]
        begins = [
            (self.grid.way(far, point) + self.grid.way(back, point), point)
            for point in self._beside((held.x, held.y), held.radius, self._radius, rest)
            if self._clear(point, rest, carried)
        ]
        begins = [(cost, point) for cost, point in begins if math.isfinite(cost)]
        if not begins:
            return None
        _, fetch = min(begins)
        there = self.grid.ways(open_, [fetch])
        deliver = self._best(ends, there)
        return None if deliver is None else Errand(part, fetch, deliver, self.grid.way(far, fetch))

    def _beside(self, centre: Vector, radius: float, own: float, rest: list[Shape]) -> Iterator[Vector]:
        """Places for a disk of radius `own` from which a part is within reach, clear of the rest."""
        distance = own + radius + 0.5 * self._reach
        for number in range(DIRECTIONS):
            angle = math.tau * number / DIRECTIONS
            point = centre[0] + distance * math.cos(angle), centre[1] + distance * math.sin(angle)
            if self._clear(point, rest, own):
                yield point

    def _clear(self, point: Vector, shapes: list[Shape], radius: float) -> bool:
        room = radius + MARGIN * self._reach
        inside = self.grid.room.distance(*point) + room <= 0.0
        return inside and all(shape.distance(*point) >= room for shape in shapes)

    def _best(self, places: Iterable[Vector], far: Reals) -> Vector | None:
        return next(iter(self._by_way(places, far)), None)

    def _by_way(self, places: Iterable[Vector], far: Reals) -> list[Vector]:
        """Places to which there is a way, the nearest first."""
        found = [(self.grid.way(far, point), point) for point in places]
        return [point for way, point in sorted(found) if math.isfinite(way)]


def _without(floor: Mapping[int, Vector], part: int) -> dict[int, Vector]:
    return {each: at for each, at in floor.items() if each != part}
