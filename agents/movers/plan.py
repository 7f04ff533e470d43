"""Which parts can be brought to their goals, and from where one is taken up and put down.

A part is fetched by a disk that gets beside it, and carried by the larger disk that both together are; it is
put down from beside its goal. What stands, other parts among it, is in the way of both; robots are not: they
give way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

from agents.movers.floor import Grid, Reals
from agents.movers.order import Orders
from agents.movers.places import MARGIN, Floor, Places
from agents.movers.reach import Reach
from protocol.geometry import Disk
from protocol.messages import Vector
from protocol.scenario.model import CELLS, Scenario

_OTHER: Final = 7  # places on from one attempt to the next
_TRIES: Final = 60  # spare places that are looked at
_ORDERS: Final = 12  # of them, for which an order is looked for


@dataclass(frozen=True)
class Errand:
    """To fetch a part.

    Attributes:
        fetch: where the carrier stands to take it up, m.
        cost: length of the way there, m.
    """

    part: int
    fetch: Vector
    cost: float


class Planner:
    """Plans for robots of one radius.

    Args:
        scenario: with the radii of robots that carry nothing.
        radius: of a robot that carries nothing, m.

    Attributes:
        grid: the cells that ways are looked for on.
        orders: in which parts find their ways.
    """

    def __init__(self, scenario: Scenario, radius: float) -> None:
        smallest = min([radius, *(part.radius for part in scenario.parts)])
        self.grid = Grid(scenario.workspace.shape, smallest / CELLS)
        self._places = Places(scenario, radius, self.grid)
        self.orders = Orders(self._places, Reach(self.grid))
        self._parts, self.loaded = self._places.parts, self._places.loaded
        self._homes = [Disk(*robot.goal, robot.radius) for robot in scenario.robots]

    def errands(self, position: Vector, floor: Floor) -> Iterator[Errand]:
        """Parts that a robot at a position (m) can bring to their goals as all stands, the nearest first."""
        far = self._far(position, floor)
        near = []
        for part in floor.parts:
            if not self._places.is_home(part, floor):
                places = self._by_way(self._places.to_take(part, floor), far)
                if places:
                    near.append((self.grid.way(far, places[0]), part))
        for _, part in sorted(near):
            errand = self._errand(part, floor, far)
            if errand is not None:
                yield errand

    def errand(self, part: int, position: Vector, floor: Floor) -> Errand | None:
        """How one part that stands is brought to its goal."""
        return self._errand(part, floor, self._far(position, floor))

    def beside(self, part: int, position: Vector, floor: Floor) -> Vector | None:
        """Where to take a part up, wherever it is brought then, m; None if there is no way."""
        places = self._by_way(self._places.to_take(part, floor), self._far(position, floor))
        return places[0] if places else None

    def delivery(
        self, part: int, target: Vector, position: Vector, floor: Floor, attempt: int = 0
    ) -> Vector | None:
        """From where to put a part down at `target` that is carried from a position, m; None if there is no
        way. The nearest place at the first attempt, others at later ones; one after which all find their
        ways, too, if there is any."""
        places = self._places.to_put(part, target, floor)
        found = self._by_way(places, self._carried(part, position, floor))
        after = floor.moved(part, target)
        found = [each for each in found if self.has_order(after, each)] or found
        return found[attempt * _OTHER % len(found)] if found else None

    def refuge(self, part: int, position: Vector, floor: Floor) -> Vector | None:
        """The place farthest from its goal to which a part can be carried, m; None if it cannot be moved."""
        far = self._carried(part, position, floor)
        goal, x, y = self._parts[part].goal, self.grid.x, self.grid.y
        reached = [(float(x[c]), float(y[c])) for c in zip(*(far < math.inf).nonzero(), strict=True)]
        return max(reached, key=lambda cell: (math.dist(cell, goal), cell), default=None)

    def destination(self, part: int, position: Vector, floor: Floor) -> Vector:
        """Where to bring a part that is carried, m: its goal, unless there is an order only if it is put
        elsewhere first, or no way."""
        goal = self._parts[part].goal
        place = self.delivery(part, goal, position, floor)
        if place is not None and self.has_order(floor.moved(part, goal), place):
            return goal
        aside = self._aside(part, position, floor)
        if aside is None and place is None:
            aside = self.spare(part, position, floor)
        return aside or goal

    def has_order(self, floor: Floor, position: Vector) -> bool:
        """Whether all can get to their goals once everybody has done what it is about to do."""
        return self.orders.exists(floor.settled, [position, *floor.robots])

    def barred(self, floor: Floor) -> list[int]:
        """Parts at whose goals something stands for good."""
        return [part for part in self._parts if self._places.is_barred(part, floor)]

    def leads_on(self, part: int, floor: Floor, position: Vector) -> bool:
        """Whether they can if a robot brings this part there next."""
        return self.orders.leads_on(part, floor.settled, position, floor.robots)

    def spare(self, part: int, position: Vector, floor: Floor) -> Vector | None:
        """A place near by where a part that is carried is in nobody's place, m; None if there is none."""
        return next((cell for cell, _ in self._spares(part, position, floor)), None)

    def clearing(self, position: Vector, floor: Floor) -> Errand | None:
        """A part that keeps others from their goals where it stands, to be put aside; None if there is none
        that can be."""
        far = self._far(position, floor)
        for part in sorted(floor.parts):
            without = floor.without(part)
            places = self._by_way(self._places.to_take(part, floor), far)
            bars = self._bars(part, floor)
            if not places or not (bars or self.has_order(without, position)):
                continue
            aside = (self.spare if bars else self._aside)(part, places[0], without)
            if aside is not None:
                return Errand(part, places[0], self.grid.way(far, places[0]))
        return None

    def _aside(self, part: int, position: Vector, floor: Floor) -> Vector | None:
        """A spare place after which there is an order, m; None if none of the nearest is that."""
        spares = islice(self._spares(part, position, floor), _ORDERS)
        return next((cell for cell, place in spares if self.has_order(floor.moved(part, cell), place)), None)

    def _spares(self, part: int, position: Vector, floor: Floor) -> Iterator[tuple[Vector, Vector]]:
        """Where a part that is carried is in nobody's place, and from where it is put down there, m; the
        nearest first."""
        radius = self._parts[part].radius
        goals = [Disk(*spec.goal, spec.radius) for each, spec in self._parts.items() if each != part]
        shapes = [*self._places.standing(floor), *goals, *self._homes]
        free = self.grid.clear(shapes, radius + MARGIN * self._places.reach)
        cells = [(float(self.grid.x[c]), float(self.grid.y[c])) for c in zip(*free.nonzero(), strict=True)]
        cells.sort(key=lambda cell: (math.dist(cell, position), cell))
        far = self._carried(part, position, floor)
        for cell in cells[:: max(1, len(cells) // _TRIES)]:
            places = self._by_way(self._places.to_put(part, cell, floor), far)
            if places:
                yield cell, places[0]

    def _bars(self, part: int, floor: Floor) -> bool:
        """Whether a part stands in another's place."""
        disk = Disk(*floor.parts[part], self._places.size(part, floor))
        others = [spec for each, spec in self._parts.items() if each != part]
        return any(disk.distance(*spec.goal) < spec.radius for spec in others)

    def _errand(self, part: int, floor: Floor, far: Reals) -> Errand | None:
        rest, goal = floor.without(part), self._parts[part].goal
        ends = self._places.to_put(part, goal, rest)
        begins = self._by_way(self._places.to_take(part, floor), far)
        if not ends or not begins:
            return None
        open_ = self.grid.clear(self._places.standing(rest), self.loaded(part))
        back = self.grid.ways(open_, ends)
        costs = self.grid.lengths(far, begins) + self.grid.lengths(back, begins)
        cost, fetch = min(zip(map(float, costs), begins, strict=True))
        return Errand(part, fetch, self.grid.way(far, fetch)) if math.isfinite(cost) else None

    def _far(self, position: Vector, floor: Floor) -> Reals:
        """How far it is to everywhere for a robot that carries nothing, m."""
        free = self.grid.clear(self._places.standing(floor), self._places.radius)
        return self.grid.ways(free, [position])

    def _carried(self, part: int, position: Vector, floor: Floor) -> Reals:
        """How far it is to everywhere for a robot with a part, m."""
        free = self.grid.clear(self._places.standing(floor), self.loaded(part))
        return self.grid.ways(free, [position])

    def _by_way(self, places: Sequence[Vector], far: Reals) -> list[Vector]:
        """Places to which there is a way, the nearest first."""
        found = zip(map(float, self.grid.lengths(far, places)), places, strict=True)
        return [point for way, point in sorted(found) if math.isfinite(way)]
