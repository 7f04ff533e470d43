"""One life of a robot id, as the coordinator knows it: docs/concepts/states.md draws it."""

from __future__ import annotations

from enum import Enum, auto
from typing import Literal

import msgspec
from msgspec.structs import replace


class Status(Enum):
    """What the world takes the process of a robot to be."""

    UP = auto()  # takes part
    PAUSED = auto()  # stopped by the scenario: hears nothing
    GONE = auto()  # not there, or ended by the scenario
    LOST = auto()  # given up on or fenced; may still listen


Fate = Literal["", "ended", "removed"]  # what the run has made of a process; "": nothing


class Life(msgspec.Struct, array_like=True):
    """The newest life of one robot id."""

    incarnation: int
    status: Status = Status.GONE
    joined: bool = False  # its present process has joined this run
    awaited: bool = True  # the scenario says that it must be up
    heard: int = -1  # tick of its newest command; the tick before it joined until there is one
    before: int = -1  # the tick before it joined
    fenced: bool = False  # it never moves again
    fate: Fate = ""  # of the newest process: ended by the scenario, or its robot was removed

    @property
    def is_new(self) -> bool:
        """Whether it has not commanded yet."""
        return self.heard <= self.before

    @property
    def paused(self) -> bool:
        """Whether the scenario holds its process still: it cannot join before it is resumed."""
        return self.status is Status.PAUSED

    @property
    def killed(self) -> bool:
        """Whether the scenario has ended its process, and does not want it back at present."""
        return self.status is Status.GONE and not self.awaited

    @property
    def goes_on(self) -> bool:
        """Whether it has joined and is neither over nor given up on."""
        return self.status in (Status.UP, Status.PAUSED) and self.joined and not self.fenced

    def over(self, tick: int) -> Life:
        """This life as another coordinator finds it that begins with `tick`: it is over. The process of one
        that took part is to join again."""
        up = self.status is Status.UP
        status, awaited = Status.LOST if up else self.status, self.awaited or up
        return replace(
            self, status=status, joined=False, awaited=awaited, heard=tick - 1, before=tick - 1, fenced=True
        )

    def kill(self) -> None:
        """The scenario ends its process."""
        self._end(awaited=False)

    def pause(self) -> None:
        """The scenario holds its process still."""
        if self.awaited or self.status in (Status.UP, Status.LOST):
            self.status, self.awaited = Status.PAUSED, False

    def resume(self) -> None:
        """The scenario lets its process go on: this life, or the next if this one was fenced meanwhile."""
        if self.paused:
            self.status, self.awaited = (Status.UP, False) if self.goes_on else (Status.LOST, True)

    def restart(self) -> None:
        """The scenario ends its process, and wants another in its place."""
        self._end(awaited=True)

    def _end(self, awaited: bool) -> None:
        self.status, self.awaited, self.joined, self.fate = Status.GONE, awaited, False, self.fate or "ended"
