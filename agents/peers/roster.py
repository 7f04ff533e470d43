"""The roster as one robot knows it: a directory of disks, obstacles and parts, for laws and carriers. What a
robot obeys does not depend on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from protocol.geometry import Shape
from protocol.messages import Member, PartPlace, Roster, Thing
from protocol.process.newest import keeps_newest


@keeps_newest
def _by_id(members: tuple[Member, ...]) -> Mapping[int, Member]:
    """What robots of one process are told alike is kept once; nobody changes it."""
    return {each.robot: each for each in members}


@final
class KnownRoster:
    """The newest roster heard by one life of one robot.

    Args:
        robot: own id.
        listed: shapes of the scenario's obstacles, by number.

    Attributes:
        version: of it; 0 as long as there is none.
        members: every robot that it names, by id, in its order.
        things: that came or went, as it says.
        parts: where each is.
        shapes: of all obstacles that are there, or are to appear.
    """

    def __init__(self, robot: int, listed: Mapping[int, Shape]) -> None:
        self.version = 0
        self.things: tuple[Thing, ...] = ()
        self.parts: tuple[PartPlace, ...] = ()
        self._robot, self._listed = robot, listed
        self.members: Mapping[int, Member] = {}
        self.shapes: list[Shape] = list(listed.values())

    def update(self, roster: Roster) -> list[Member]:
        """Take over a roster if it is newer; what it says anew of others, in the order of their ids."""
        if roster.version <= self.version:
            return []
        before, self.members = self.members, _by_id(roster.members)
        if roster.things != self.things:
            shapes = dict(self._listed)
            for thing in roster.things:
                shapes.pop(thing.number, None)
                if thing.status != "gone":
                    shapes[thing.number] = thing.shape
            self.shapes = list(shapes.values())
        self.version, self.things, self.parts = roster.version, roster.things, roster.parts
        return [
            each
            for each in self.members.values()
            if each.robot != self._robot and before.get(each.robot) != each
        ]

    def member(self, robot: int) -> Member | None:
        """What it says of an id."""
        return self.members.get(robot)


def has_ended(roster: Roster, robot: int, incarnation: int) -> bool:
    """Whether a roster says that this incarnation is over: its disk stands, or a newer incarnation is
    there."""
    for member in roster.members:
        if member.robot == robot and member.incarnation >= incarnation:
            return member.incarnation > incarnation or member.status != "live"
    return False
