"""The fleet as a scenario begins it. Robots of one process are told the same, and share what follows from it:
in each of a thousand it would be a thousand numbers, far from what it needs in every tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from protocol.process.newest import keeps_newest
from protocol.scenario.model import RobotSpec


class Fleet(NamedTuple):
    """Who is in it, by id; nobody changes it.

    Attributes:
        ids: of all.
        radii: of their disks, m.
    """

    ids: frozenset[int]
    radii: Mapping[int, float]


@keeps_newest
def fleet_of(robots: tuple[RobotSpec, ...]) -> Fleet:
    """The fleet of a scenario's robots."""
    radii = {robot.id: robot.radius for robot in robots}
    return Fleet(frozenset(radii), radii)
