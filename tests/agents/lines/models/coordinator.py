"""Decides who is there, may die at any moment, and goes on from what it has written down."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from protocol.errors import RosterError
from protocol.messages import Roster
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.twins import twin_of_roster


class Coordinator:
    """The real roster, and what was told of it.

    Attributes:
        roster: the real one.
        announced: every version ever told, in the order in which they were.
    """

    def __init__(self, product: Product, saved: bool) -> None:
        self.roster = product.Roster()
        self.announced: list[Roster] = []
        self._in_time = saved
        self._saved = twin_of_roster(self.roster)

    def decide(self, act: Callable[[Any], object]) -> bool:
        """Change the roster and announce it; False if it refuses, or if nothing changes."""
        before, version = twin_of_roster(self.roster), self.roster.version
        try:
            act(self.roster)
        except RosterError:
            return False
        if self.roster.version == version:
            return False
        self._saved = twin_of_roster(self.roster) if self._in_time else before
        self.announced.append(self.roster.message)
        return True

    def restart(self) -> None:
        """Die, and go on from what is written down."""
        self.roster = twin_of_roster(self._saved)
