"""Processes that were admitted, by the names that they gave themselves, and which never come back.

One that the scenario has ended may live on for a while, and so may one whose robot was removed: it is no
other life of its robot, and no life of another robot with the same id, however often a token, a router or a
world goes in between. What became of a robot's newest process its newest life says.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from protocol.messages import Id
from world.coordinator.life import Fate, Life

_KEPT = 16  # earlier processes of a robot that are told what became of them


class Processes(msgspec.Struct):
    """Of one world."""

    newest: dict[Id, str] = {}  # of each robot that had one
    over: dict[Id, dict[str, Fate]] = {}  # earlier ones, in the order in which they were

    def admit(self, robot: int, session: str, before: Fate) -> None:
        """A process is the newest of a robot; `before` is what had become of the one before it."""
        earlier = self.newest.get(robot, "")
        if earlier != session:
            self._keep(robot, earlier, before)
        self.newest[robot] = session

    def fate(self, robot: int, session: str, lives: Mapping[int, Life]) -> Fate:
        """What became of a process; "" if it may be the robot's next life."""
        life = lives.get(robot)
        if life is not None and session == self.newest.get(robot):
            return life.fate
        return self.over.get(robot, {}).get(session, "")

    def _keep(self, robot: int, session: str, fate: Fate) -> None:
        if session and fate:
            fates = self.over.setdefault(robot, {})
            fates[session] = fate
            if len(fates) > _KEPT:
                del fates[next(iter(fates))]
