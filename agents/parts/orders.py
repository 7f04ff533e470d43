"""Whether there is an order in which one part after another gets to its goal.

Some robot takes up a part that it gets beside, brings it straight to its goal as one larger disk, and puts it
down; the others are not in its way meanwhile. What matters of where a robot is, is which cells it gets to:
the search goes through all orders, and all such sets of cells, once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from agents.parts.grid import Reach
from agents.parts.layout import Layout, Places
from protocol.messages import Vector

_Regions = tuple[int, ...]  # cells that each robot gets to, ascending
_State = tuple[tuple[tuple[int, Vector], ...], tuple[object, ...], _Regions]

MOST: Final = 2000  # times that one search looks where somebody gets by bringing a part to its goal
_KEPT: Final = 20_000  # states whose outcome is remembered


class Orders:
    """Orders for robots of one radius."""

    def __init__(self, places: Places, reach: Reach) -> None:
        self._places, self._reach = places, reach
        self._known: dict[_State, bool] = {}

    def exists(self, layout: Layout, robots: Sequence[Vector]) -> bool:
        """Whether robots at these places (m) could bring all parts to their goals, without those whose goals
        are barred for good."""
        return self._found(layout, self._regions(layout, robots))

    def leads_on(self, part: int, layout: Layout, robot: Vector, others: Sequence[Vector]) -> bool:
        """Whether there is such an order that begins with a robot and a part."""
        after = layout.moved(part, self._goal(part))
        (own,), rest = self._regions(layout, [robot]), self._regions(after, others)
        outcomes = self._outcomes(part, layout, own)
        return any(self._found(after, tuple(sorted((*rest, each)))) for each in outcomes)

    def can_fetch(self, part: int, layout: Layout, robot: Vector) -> bool:
        """Whether a robot gets beside a part, and from there to its goal with it."""
        (own,) = self._regions(layout, [robot])
        return any(True for _ in self._outcomes(part, layout, own))

    def can_deliver(self, part: int, layout: Layout, robot: Vector) -> bool:
        """Whether a robot that has a part in hand gets to its goal with it."""
        return bool(self._ends(part, layout, [robot]))

    def _regions(self, layout: Layout, robots: Sequence[Vector]) -> _Regions:
        """Where robots get to that carry nothing."""
        free = self._reach.clear(self._places.standing(layout), self._places.radius)
        return tuple(sorted(self._reach.spread(free, [robot]) for robot in robots))

    def _found(self, layout: Layout, regions: _Regions) -> bool:
        """What one search finds; one that was cut short has found nothing, and is not made again."""
        found = self._search(layout, regions, [MOST])
        self._known[self._state(layout, regions)] = found
        return found

    def _state(self, layout: Layout, regions: _Regions) -> _State:
        return tuple(sorted(layout.parts.items())), (*layout.others, *sorted(layout.held)), regions

    def _search(self, layout: Layout, regions: _Regions, budget: list[int]) -> bool:
        left = [part for part in sorted(layout.parts) if not self._is_done(part, layout)]
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

    def _is_done(self, part: int, layout: Layout) -> bool:
        return self._places.is_home(part, layout) or self._places.is_barred(part, layout)

    def _turns(self, part: int, layout: Layout, regions: _Regions) -> Iterator[_Regions]:
        """Where robots may get to when one of them has brought a part to its goal."""
        after = layout.moved(part, self._goal(part))
        free = self._reach.clear(self._places.standing(after), self._places.radius)
        for region in sorted(set(regions)):
            others = list(regions)
            others.remove(region)
            for own in self._outcomes(part, layout, region):
                yield tuple(sorted((own, *(self._reach.widest(free, each) for each in others))))

    def _outcomes(self, part: int, layout: Layout, region: int) -> Iterator[int]:
        """Where a robot may get to, each once, when it has brought a part to its goal."""
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
        """Where a part can be put down at its goal that is carried from one of some places."""
        ends = self._places.to_put(part, self._goal(part), layout)
        if not ends:
            return []
        shapes, loaded = self._places.standing(layout), self._places.loaded(part)
        carried = self._reach.spread(self._reach.clear(shapes, loaded), begins)
        return self._reach.among(carried, ends)

    def _goal(self, part: int) -> Vector:
        return self._places.parts[part].goal
