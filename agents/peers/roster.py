"""The roster as one robot has received it: a directory of all disks, obstacles and parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from protocol.codec import keeps_newest
from protocol.geometry import Shape
from protocol.messages import Member, PartPlace, PlacedObstacle, Roster
from protocol.scenario.model import RobotSpec


@keeps_newest
def _by_id(members: tuple[Member, ...]) -> tuple[dict[int, Member], dict[int, int]]:
    """Members, and incarnations of live ones, by id. Immutable: robots of one process share them."""
    lives = {each.robot: each.incarnation if each.status == "live" else -1 for each in members}
    return {each.robot: each for each in members}, lives


@final
class KnownRoster:
    """The newest roster received by one life of one robot.

    Args:
        listed: shapes of the scenario's obstacles, by number.

    Attributes:
        version: 0 before the first.
        members: its entries, by id, in its order.
        lives: incarnation of each live robot, by id; -1 if the disk is not live.
        obstacles: its added and removed obstacles.
        parts: the place of each part.
        shapes: of all obstacles that are present or appearing.
        numbered: the same shapes, by number.
    """

    def __init__(self, robot: int, listed: Mapping[int, Shape]) -> None:
        self.version = 0
        self.obstacles: tuple[PlacedObstacle, ...] = ()
        self.parts: tuple[PartPlace, ...] = ()
        self._robot, self._listed = robot, listed
        self.members: dict[int, Member] = {}
        self.lives: dict[int, int] = {}
        self.numbered = listed
        self.shapes = tuple(listed.values())

    def update(self, roster: Roster) -> list[Member]:
        """Adopt a roster if it is newer; returns the entries of peers that changed, by id."""
        if roster.version <= self.version:
            return []
        before = self.members
        self.members, self.lives = _by_id(roster.members)
        if roster.obstacles != self.obstacles:
            shapes = dict(self._listed)
            for obstacle in roster.obstacles:
                shapes.pop(obstacle.number, None)
                if obstacle.status != "gone":
                    shapes[obstacle.number] = obstacle.shape
            self.numbered, self.shapes = shapes, tuple(shapes.values())
        self.version, self.obstacles, self.parts = roster.version, roster.obstacles, roster.parts
        return [
            each
            for each in self.members.values()
            if each.robot != self._robot and before.get(each.robot) != each
        ]


@keeps_newest
def radii_of(robots: tuple[RobotSpec, ...]) -> dict[int, float]:
    """Radii of the robots of a fleet, m, by id. Immutable: robots of one process share them."""
    return {robot.id: robot.radius for robot in robots}
