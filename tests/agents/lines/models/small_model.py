"""Two robots on a track of a few places, and every order of events: an exhaustive breadth-first search.

Robot 1, the owner of the line, begins on the left, robot 2 on the right. Which events there are, and how
often, is bounded; within that every reachable state of `track.Track` is visited, nearest first.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from tests.agents.lines.models.product import Product
from tests.agents.lines.models.track import Setting, Track

Event = Callable[[Track], bool]

ROBOTS = OWNER, _ = (1, 2)
LENGTH = 2
LINES = (0.5, 1.5)  # offsets; places are 0, 1, 2


class Bounds(NamedTuple):
    """What keeps the search finite."""

    lives: tuple[int, int] = (
        1,
        1,
    )  # of robot 1 and 2, founding ones and an incarnation 0 that never was included
    proposals: int = 2  # numbers used in one incarnation of the owner
    outstanding: int = 1  # unanswered proposals at once
    founding: tuple[int, ...] = ROBOTS
    fences: int = 0
    removals: int = 0  # disks that are taken away
    appearances: int = 0  # disks that are announced, each at any place
    deaths: int = 0  # of the coordinator
    versions: int = 6  # of the roster; with the above nearly always enough
    talks_on: bool = False  # whether former incarnations hear and talk
    starts: tuple[int, int] = (0, LENGTH)


class Search(NamedTuple):
    """What a search found.

    Attributes:
        visited: states.
        violation: "" if there is none.
    """

    visited: int
    violation: str


class _Always(NamedTuple):
    """Places the same line, whoever the peer is."""

    line: Any

    def __call__(self, _: int) -> Any:
        return self.line


class _Count(NamedTuple):
    """Events of the bounded kinds so far."""

    fences: int = 0
    removals: int = 0
    appearances: int = 0
    deaths: int = 0


def search(bounds: Bounds, product: Product, saved: bool = True, most: int = 1_000_000) -> Search:
    """Visit all states reachable within `bounds`, nearest first, until one breaks the invariant.

    Args:
        saved: whether the coordinator writes down what it decided before it tells anybody.
        most: states.

    Raises:
        AssertionError: there are more.
    """
    start = Track(product, _setting(bounds, saved))
    queue = deque([(start, _Count())])
    seen = {(start.key(), _Count())}
    while queue:
        track, count = queue.popleft()
        violation = track.violation()
        if violation:
            return Search(len(seen), violation)
        for event, counted in _events(track, bounds, count):
            after = track.twin()
            if not event(after):
                continue
            if not bounds.talks_on:
                after.forget()
            key = after.key(), counted
            if key not in seen:
                seen.add(key)
                queue.append((after, counted))
        assert len(seen) <= most, f"the model is larger than {most} states: {bounds}"
    return Search(len(seen), "")


def _setting(bounds: Bounds, saved: bool) -> Setting:
    starts = dict(zip(ROBOTS, map(float, bounds.starts), strict=True))
    return Setting(starts, length=float(LENGTH), founding=frozenset(bounds.founding), saved=saved)


def _events(track: Track, bounds: Bounds, count: _Count) -> Iterator[tuple[Event, _Count]]:
    for robot in ROBOTS:
        place = track.truth[robot]
        if place is not None:
            yield partial(Track.move, robot=robot, place=max(0.0, place - 1.0)), count
            yield partial(Track.move, robot=robot, place=min(float(LENGTH), place + 1.0)), count
    for event in _talk(track, bounds):
        yield event, count
    if any(each.status == "appearing" for each in track.members()):
        for robot in ROBOTS:
            yield partial(Track.acknowledge, robot=robot), count
    if track.coordinator.roster.version < bounds.versions:
        yield from _decisions(track, bounds, count)
    if count.deaths < bounds.deaths:
        yield Track.restart, count._replace(deaths=count.deaths + 1)


def _talk(track: Track, bounds: Bounds) -> Iterator[Event]:
    """What is said and heard."""
    for who, seat in track.seats.items():
        if seat.ledger is not None:
            if seat.robot != OWNER or all((state.robot, state.incarnation) != who for state in track.sent):
                yield partial(Track.entries, who=who)  # answers, or only that it is there
            end = seat.ledger._each[0].end
            if (
                seat.robot == OWNER
                and end.number < bounds.proposals
                and len(end.proposed) < bounds.outstanding
            ):
                for offset in LINES:
                    line = track.product.Line(1.0, 0.0, offset)
                    yield partial(Track.entries, who=who, choose=_Always(line))
            for state in track.sent:
                if state.robot != seat.robot:
                    yield partial(Track.hear, who=who, state=state)
        for roster in track.coordinator.announced:
            yield partial(Track.be_told, who=who, roster=roster)


def _decisions(track: Track, bounds: Bounds, count: _Count) -> Iterator[tuple[Event, _Count]]:
    for robot, lives in zip(ROBOTS, bounds.lives, strict=True):
        if track.newest.get(robot, 0) < lives:
            yield partial(Track.join, robot=robot), count
        if count.fences < bounds.fences:
            yield partial(Track.fence, robot=robot), count._replace(fences=count.fences + 1)
        if count.removals < bounds.removals:
            yield partial(Track.remove, robot=robot), count._replace(removals=count.removals + 1)
        if count.appearances < bounds.appearances:
            for place in range(LENGTH + 1):
                event = partial(Track.announce, robot=robot, place=float(place))
                yield event, count._replace(appearances=count.appearances + 1)
    yield Track.settle, count
