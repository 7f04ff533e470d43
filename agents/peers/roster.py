"""The roster as one robot knows it: the newest version that it has heard. Decisions about incarnations are
the coordinator's; this robot only follows its versions, and never an older one than it already knows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

from protocol.messages import Member, PartPlace, Roster, Thing
from protocol.process.newest import keeps_newest


@keeps_newest
def _by_id(members: tuple[Member, ...]) -> Mapping[int, Member]:
    """What robots of one process are told alike is kept once; nobody changes it."""
    return {each.robot: each for each in members}


@final
class KnownRoster:
    """The newest roster heard by one incarnation of one robot.

    Args:
        robot: own id.
        incarnation: own incarnation.

    Attributes:
        version: of it; 0 as long as there is none.
        members: everybody that it names, by id, in its order.
        things: that came or went, as it says.
        parts: where each is.
    """

    def __init__(self, robot: int, incarnation: int) -> None:
        self.version = 0
        self.things: tuple[Thing, ...] = ()
        self.parts: tuple[PartPlace, ...] = ()
        self._robot, self._incarnation = robot, incarnation
        self.members: Mapping[int, Member] = {}

    def update(self, roster: Roster) -> list[Member]:
        """Take over a roster if it is newer; what it says anew of others, in the order of their ids."""
        if roster.version <= self.version:
            return []
        before, self.members = self.members, _by_id(roster.members)
        self.version, self.things, self.parts = roster.version, roster.things, roster.parts
        return [
            each
            for each in self.members.values()
            if each.robot != self._robot and before.get(each.robot) != each
        ]

    def member(self, robot: int) -> Member | None:
        """What it says of an id."""
        return self.members.get(robot)

    @property
    def founding(self) -> bool:
        """Whether this incarnation was there before the first tick, and so knows the initial lines."""
        own = self.members.get(self._robot)
        return own is not None and own.founding == self._incarnation > 0


def has_ended(roster: Roster, robot: int, incarnation: int) -> bool:
    """Whether a roster says that this incarnation is over: its disk stands, or a newer incarnation is
    there."""
    for member in roster.members:
        if member.robot == robot and member.incarnation >= incarnation:
            return member.incarnation > incarnation or member.status != "live"
    return False
