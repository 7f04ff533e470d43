"""The fleet as a scenario begins it. Robots of one process are told the same, and share what follows from it:
in each of a thousand it would be a thousand numbers, far from what it needs in every tick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeVar

from protocol.scenario.model import RobotSpec

Vector = tuple[float, float]
Told = TypeVar("Told")
Follows = TypeVar("Follows")


def shared(make: Callable[[Told], Follows]) -> Callable[[Told], Follows]:
    """A function of what all robots are told that keeps its newest result. Unlike `lru_cache` it hashes
    nothing, which in each of a thousand robots would take as long as to make the result."""
    kept: list[tuple[Told, Follows]] = []

    def found(told: Told) -> Follows:
        if not kept or (told is not kept[0][0] and told != kept[0][0]):
            kept[:] = [(told, make(told))]
        return kept[0][1]

    return found


class Fleet(NamedTuple):
    """Who is in it, by id; nobody changes it.

    Attributes:
        ids: of all.
        radii: of their disks, m.
        starts: of their centres, m.
    """

    ids: frozenset[int]
    radii: Mapping[int, float]
    starts: Mapping[int, Vector]


@shared
def fleet_of(robots: tuple[RobotSpec, ...]) -> Fleet:
    """The fleet of a scenario's robots."""
    radii = {robot.id: robot.radius for robot in robots}
    return Fleet(frozenset(radii), radii, {robot.id: robot.start for robot in robots})
