"""Planning of parts: which can be brought to their goals, in which order, and from where each is handled.

A robot fetches a part if its disk can reach a place beside it, carries it as the larger disk of both, and
puts it down from beside its goal. Obstacles and other parts block both disks; robots do not, since they give
way. Only the set of cells that a robot can reach matters: the search visits every order, and every such set,
once.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from itertools import islice
from typing import Final, NamedTuple

from agents.parts.grid import MARGIN, Grid, GridPlaces, Layout, Reach
from agents.parts.perception import Perception
from protocol.arrays import Reals
from protocol.geometry import Disk
from protocol.messages import Vector
from protocol.scenario.model import CELLS, Scenario

_Regions = tuple[int, ...]  # cells that each robot can reach, ascending
_Key = tuple[tuple[tuple[int, Vector], ...], tuple[object, ...], _Regions]

MOST: Final = 2000  # deliveries tried by one search
_KEPT: Final = 20_000  # cached outcomes


class PartOrders:
    """Orders of delivery, for robots of one radius."""

    def __init__(self, places: GridPlaces, reach: Reach) -> None:
        self._places, self._reach = places, reach
        self._known: dict[_Key, bool] = {}

    def exists(self, layout: Layout, robots: Sequence[Vector]) -> bool:
        """Whether robots at these positions (m) can bring every part to its goal, unless that is covered."""
        return self._found(layout, self._regions(layout, robots))

    def leads_on(self, part: int, layout: Layout, robot: Vector, others: Sequence[Vector]) -> bool:
        """Whether such an order exists that starts with this part and robot."""
        after = layout.moved(part, self._goal(part))
        (own,), rest = self._regions(layout, [robot]), self._regions(after, others)
        outcomes = self._outcomes(part, layout, own)
        return any(self._found(after, tuple(sorted((*rest, each)))) for each in outcomes)

    def can_fetch(self, part: int, layout: Layout, robot: Vector) -> bool:
        """Whether a robot can reach a part, and from there the part's goal with it."""
        (own,) = self._regions(layout, [robot])
        return any(True for _ in self._outcomes(part, layout, own))

    def can_deliver(self, part: int, layout: Layout, robot: Vector) -> bool:
        """Whether the carrier of a part can reach the part's goal with it."""
        return bool(self._ends(part, layout, [robot]))

    def _regions(self, layout: Layout, robots: Sequence[Vector]) -> _Regions:
        """Cells that robots without a part can reach."""
        free = self._reach.clear(self._places.standing(layout), self._places.radius)
        return tuple(sorted(self._reach.spread(free, [robot]) for robot in robots))

    def _found(self, layout: Layout, regions: _Regions) -> bool:
        """Outcome of one search, cached; a search that reaches `MOST` finds no order."""
        found = self._search(layout, regions, [MOST])
        self._known[self._state(layout, regions)] = found
        return found

    def _state(self, layout: Layout, regions: _Regions) -> _Key:
        return tuple(sorted(layout.parts.items())), (*layout.others, *sorted(layout.held)), regions

    def _search(self, layout: Layout, regions: _Regions, budget: list[int]) -> bool:
        home, barred = self._places.is_home, self._places.is_barred
        left = [part for part in sorted(layout.parts) if not (home(part, layout) or barred(part, layout))]
        if not left:
            return True
        state = self._state(layout, regions)
        if state in self._known:
            return self._known[state]
        if budget[0] <= 0:
            return False
        budget[0] -= len(left)
        found = any(
            self._search(layout.moved(part, self._goal(part)), after, budget)
            for part in left
            for after in self._turns(part, layout, regions)
        )
        if found or budget[0] > 0:
            if len(self._known) >= _KEPT:
                self._known.clear()
            self._known[state] = found
        return found

    def _turns(self, part: int, layout: Layout, regions: _Regions) -> Iterator[_Regions]:
        """Cells that robots can reach after one of them has brought a part to its goal."""
        after = layout.moved(part, self._goal(part))
        free = self._reach.clear(self._places.standing(after), self._places.radius)
        for region in sorted(set(regions)):
            others = list(regions)
            others.remove(region)
            for own in self._outcomes(part, layout, region):
                yield tuple(sorted((own, *(self._reach.widest(free, each) for each in others))))

    def _outcomes(self, part: int, layout: Layout, region: int) -> Iterator[int]:
        """Each distinct region that a robot can reach after it has brought a part to its goal."""
        begins = self._reach.among(region, self._places.to_take(part, layout))
        if not begins:
            return
        ends = self._ends(part, layout.without(part), begins)
        after = layout.moved(part, self._goal(part))
        free = self._reach.clear(self._places.standing(after), self._places.radius)
        while ends:
            own = self._reach.spread(free, ends[:1])
            yield own
            found = {*self._reach.among(own, ends), ends[0]}
            ends = [end for end in ends if end not in found]

    def _ends(self, part: int, layout: Layout, begins: list[Vector]) -> list[Vector]:
        """Places from which a part can be put down at its goal, if it is carried from any of some places."""
        ends = self._places.to_put(part, self._goal(part), layout)
        if not ends:
            return []
        shapes, loaded = self._places.standing(layout), self._places.loaded(part)
        carried = self._reach.spread(self._reach.clear(shapes, loaded), begins)
        return self._reach.among(carried, ends)

    def _goal(self, part: int) -> Vector:
        return self._places.parts[part].goal


_OTHER: Final = 7  # places skipped from one attempt to the next
_TRIES: Final = 60  # spare places considered
_ORDERS: Final = 12  # spare places for which an order is searched


class Errand(NamedTuple):
    """To fetch a part."""

    part: int
    fetch: Vector  # place of the robot to take it up, m


class Planner:
    """Plans for robots of one radius, m, without a part."""

    def __init__(self, scenario: Scenario, radius: float) -> None:
        smallest = min([radius, *(part.radius for part in scenario.parts)])
        self.grid = Grid(scenario.workspace.shape, smallest / CELLS)
        self._places = GridPlaces(scenario, radius, self.grid)
        self.orders = PartOrders(self._places, Reach(self.grid))
        self._parts = self._places.parts
        self.loaded = self._places.loaded
        self._homes = [Disk(*robot.goal, robot.radius) for robot in scenario.robots]

    def errands(self, position: Vector, layout: Layout) -> Iterator[Errand]:
        """Parts that a robot at a position (m) can bring to their goals in this layout, the nearest first."""
        far = self._far(position, layout)
        near = []
        for part in layout.parts:
            if not self._places.is_home(part, layout):
                begins = self._by_way(self._places.to_take(part, layout), far)
                if begins:
                    near.append((float(self.grid.lengths(far, begins[:1])[0]), part, begins))
        for _, part, begins in sorted(near):
            fetch = self._begin(part, layout, far, begins)
            if fetch is not None:
                yield Errand(part, fetch)

    def fetch(self, part: int, position: Vector, layout: Layout) -> Vector | None:
        """The place to take a part up, m: on the shortest path to the part's goal, or the nearest if there is
        no such path; None if none can be reached."""
        far = self._far(position, layout)
        begins = self._by_way(self._places.to_take(part, layout), far)
        return self._begin(part, layout, far, begins) or next(iter(begins), None)

    def delivery(
        self, part: int, target: Vector, position: Vector, layout: Layout, attempt: int = 0
    ) -> Vector | None:
        """The place from which the carrier puts a part down at `target`, m, if possible one after which all
        parts can be delivered; the nearest at the first attempt, others later; None if there is no path."""
        places = self._places.to_put(part, target, layout)
        found = self._by_way(places, self._far(position, layout, part))
        after = layout.moved(part, target)
        found = [each for each in found if self.has_order(after, each)] or found
        return found[attempt * _OTHER % len(found)] if found else None

    def refuge(self, part: int, position: Vector, layout: Layout) -> Vector | None:
        """The place farthest from its goal to which a part can be carried, m; None if it cannot be moved."""
        far = self._far(position, layout, part)
        goal, x, y = self._parts[part].goal, self.grid.x, self.grid.y
        reached = [(float(x[c]), float(y[c])) for c in zip(*(far < math.inf).nonzero(), strict=True)]
        return max(reached, key=lambda cell: (math.dist(cell, goal), cell), default=None)

    def destination(self, part: int, position: Vector, layout: Layout) -> Vector:
        """Target of a carried part, m: its goal; elsewhere without a path, or if an order requires it."""
        goal = self._parts[part].goal
        place = self.delivery(part, goal, position, layout)
        if place is not None and self.has_order(layout.moved(part, goal), place):
            return goal
        aside = self._aside(part, position, layout)
        if aside is None and place is None:
            aside = self.spare(part, position, layout)
        return aside or goal

    def has_order(self, layout: Layout, position: Vector) -> bool:
        """Whether all other parts can be delivered after those carried or claimed are."""
        return self.orders.exists(layout.settled, [position, *layout.robots])

    def leads_on(self, part: int, layout: Layout, position: Vector) -> bool:
        """Whether they can if the robot at a position delivers this part next."""
        return self.orders.leads_on(part, layout.settled, position, layout.robots)

    def spare(self, part: int, position: Vector, layout: Layout) -> Vector | None:
        """The nearest target for a carried part that is off all goals and homes, m; None if there is none."""
        return next((cell for cell, _ in self._spares(part, position, layout)), None)

    def clearing(self, position: Vector, layout: Layout) -> Errand | None:
        """The errand to move a part that blocks the others out of the way; None if there is no such part."""
        far = self._far(position, layout)
        for part in sorted(layout.parts):
            without = layout.without(part)
            places = self._by_way(self._places.to_take(part, layout), far)
            bars = self._bars(part, layout)
            if not places or not (bars or self.has_order(without, position)):
                continue
            aside = (self.spare if bars else self._aside)(part, places[0], without)
            if aside is not None:
                return Errand(part, places[0])
        return None

    def _aside(self, part: int, position: Vector, layout: Layout) -> Vector | None:
        """A spare target after which an order exists, m; None if none of the nearest is one."""
        spares = islice(self._spares(part, position, layout), _ORDERS)
        return next((cell for cell, place in spares if self.has_order(layout.moved(part, cell), place)), None)

    def _spares(self, part: int, position: Vector, layout: Layout) -> Iterator[tuple[Vector, Vector]]:
        """Spare targets for a carried part, off all goals and homes, each with the place from which it is put
        down there, m; the nearest first."""
        radius = self._parts[part].radius
        goals = [Disk(*spec.goal, spec.radius) for each, spec in self._parts.items() if each != part]
        shapes = [*self._places.standing(layout), *goals, *self._homes]
        free = self.grid.clear(shapes, radius + MARGIN * self._places.reach)
        cells = [(float(self.grid.x[c]), float(self.grid.y[c])) for c in zip(*free.nonzero(), strict=True)]
        cells.sort(key=lambda cell: (math.dist(cell, position), cell))
        far = self._far(position, layout, part)
        for cell in cells[:: max(1, len(cells) // _TRIES)]:
            places = self._by_way(self._places.to_put(part, cell, layout), far)
            if places:
                yield cell, places[0]

    def _bars(self, part: int, layout: Layout) -> bool:
        disk = Disk(*layout.parts[part], self._places.size(part, layout))
        others = [spec for each, spec in self._parts.items() if each != part]
        return any(disk.distance(*spec.goal) < spec.radius for spec in others)

    def _begin(self, part: int, layout: Layout, far: Reals, begins: Sequence[Vector]) -> Vector | None:
        """Of the places to take a part up, that on the shortest path to its goal, m; None without a path."""
        rest = layout.without(part)
        ends = self._places.to_put(part, self._parts[part].goal, rest)
        open_ = self.grid.clear(self._places.standing(rest), self.loaded(part))
        back = self.grid.distance_field(open_, ends)
        return next(iter(self._by_way(begins, far, back)), None)

    # -- the next part, given the claims of peers

    def choose(self, position: Vector, perception: Perception, avoided: Collection[int]) -> Errand | None:
        """The nearest part after which any robot can deliver all others, too; if there is no order for all,
        one that makes room; None to wait. `avoided`: parts that could not be reached."""
        nearest: Errand | None = None
        layout = perception.layout
        for errand in self.errands(position, layout):
            if errand.part in layout.promised or errand.part in avoided:
                continue
            nearest = nearest or errand
            if self.fits(errand.part, position, perception):
                return errand
        if layout.promised or self.has_order(layout, position):
            return None
        return self.clearing(position, layout) or nearest

    def fits(self, part: int, position: Vector, perception: Perception) -> bool:
        """Whether all parts can be delivered if a robot delivers this one next, in parallel with the claims,
        each of which has a path after any one of the others, and after all of them."""
        if not self.leads_on(part, perception.layout, position):
            return False
        at = {peer.robot: peer.position for peer in perception.peers}
        jobs = {claim.part: at[robot] for robot, claim in perception.claims} | {part: position}
        for each, begin in jobs.items():
            others = [other for other in jobs if other != each]
            for done in ([], *([other] for other in others), others):
                layout = perception.layout
                for other in done:
                    layout = layout.moved(other, self._parts[other].goal)
                finds = self.orders.can_fetch if each in layout.parts else self.orders.can_deliver
                if begin is not None and not finds(each, layout, begin):
                    return False
        return True

    # -- distances

    def _far(self, position: Vector, layout: Layout, part: int = 0) -> Reals:
        """Distance field of a robot with a part, or without one, m."""
        radius = self.loaded(part) if part else self._places.radius
        return self.grid.distance_field(self.grid.clear(self._places.standing(layout), radius), [position])

    def _by_way(self, places: Sequence[Vector], *fields: Reals) -> list[Vector]:
        """Places with a path in each distance field, that with the least sum first."""
        ways = zip(*(self.grid.lengths(far, places).tolist() for far in fields), strict=True)
        found = zip(map(sum, ways), places, strict=True)
        return [point for way, point in sorted(found) if math.isfinite(way)]
