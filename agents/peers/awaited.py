"""Whose States of the present tick have not arrived yet."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from mypy_extensions import mypyc_attr


@final
@mypyc_attr(acyclic=True)
class Awaited:
    """A barrier for one tick after another, at which some may arrive before it is put up.

    Args:
        robot: own id; nobody waits for oneself.

    Attributes:
        robots: who is awaited.
    """

    __slots__ = ("_ahead", "_robot", "_tick", "robots")

    def __init__(self, robot: int) -> None:
        self._robot, self._tick = robot, -1
        self.robots: set[int] = set()
        self._ahead: dict[int, int] = {}  # newest tick, by peer that is ahead of this robot

    def begin(self, tick: int, active: Iterable[int]) -> None:
        """Await the States of `tick` of all who take part and have not sent theirs yet."""
        self._tick = tick
        self.robots = set(active)
        self.robots.discard(self._robot)
        if self._ahead:
            self._ahead = {peer: newest for peer, newest in self._ahead.items() if newest >= tick}
            self.robots.difference_update(self._ahead)

    def arrived(self, robot: int, tick: int) -> None:
        """A State of `tick` is there."""
        if tick >= self._tick:
            self.robots.discard(robot)
        if tick > self._tick and tick > self._ahead.get(robot, -1):
            self._ahead[robot] = tick

    def reduce(self, active: Iterable[int]) -> None:
        """Some no longer take part."""
        self.robots.intersection_update(active)
