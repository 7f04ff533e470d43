"""Records of the coordinator that a successor receives: lives and missions.

They are interpreted: classes that mypyc compiles cannot be decoded.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Literal

import msgspec

from protocol import messages
from protocol.messages import Count, Id, OrderStatus, Standing, Vector


class LifeStatus(Enum):
    """State of a robot's process, by the world's knowledge."""

    UP = auto()  # active
    PAUSED = auto()  # paused by the scenario: receives nothing
    GONE = auto()  # absent, or ended by the scenario
    LOST = auto()  # given up or fenced; may still listen


Fate = Literal["", "ended", "removed"]  # of a process, by the run; "": none


class Life(msgspec.Struct, array_like=True):
    """The newest life of one robot id."""

    incarnation: int
    status: LifeStatus = LifeStatus.GONE
    joined: bool = False  # its present process has joined this run
    awaited: bool = True  # the scenario has it up
    heard: int = -1  # tick of its newest command, initially the tick before it joined
    before: int = -1  # the tick before it joined
    fenced: bool = False  # its disk is static
    begun: bool = False  # it has begun in the ledger
    added: bool = False  # its disk was added to the running fleet, and no process has joined it yet
    fate: Fate = ""  # of the newest process: ended by the scenario, or its robot was removed

    @property
    def is_new(self) -> bool:
        """Whether it has not commanded yet."""
        return self.heard <= self.before

    @property
    def paused(self) -> bool:
        """Whether the scenario has paused its process, which cannot join before it is resumed."""
        return self.status is LifeStatus.PAUSED

    @property
    def killed(self) -> bool:
        """Whether the scenario has killed its process without a restart so far."""
        return self.status is LifeStatus.GONE and not self.awaited

    @property
    def goes_on(self) -> bool:
        """Whether it has joined and is neither over nor lost."""
        return self.status in (LifeStatus.UP, LifeStatus.PAUSED) and self.joined and not self.fenced

    def over(self, tick: int) -> Life:
        """This life for a successor from `tick`: it is over; the process of an active one must rejoin."""
        up = self.status is LifeStatus.UP
        status, awaited = LifeStatus.LOST if up else self.status, self.awaited or up
        life = Life(self.incarnation, status, awaited=awaited, heard=tick - 1, before=tick - 1, fenced=True)
        life.fate, life.added = self.fate, self.added
        return life

    def kill(self) -> None:
        """Apply the scenario's kill of its process."""
        self._end(awaited=False)

    def restart(self) -> None:
        """Apply the restart of its process."""
        self._end(awaited=True)

    def _end(self, awaited: bool) -> None:
        self.status, self.awaited, self.joined, self.fate = (
            LifeStatus.GONE,
            awaited,
            False,
            self.fate or "ended",
        )

    def pause(self) -> None:
        """Apply the scenario's pause of its process."""
        if self.awaited or self.status in (LifeStatus.UP, LifeStatus.LOST):
            self.status, self.awaited = LifeStatus.PAUSED, False

    def resume(self) -> None:
        """Apply the resumption of its process: of this life, or the next if this one was fenced meanwhile."""
        if self.paused:
            self.status, self.awaited = (LifeStatus.UP, False) if self.goes_on else (LifeStatus.LOST, True)


class PastLives(msgspec.Struct, frozen=True):
    """The lives of a run up to a tick, as attributes of `Lives`, with roster and version."""

    of: dict[Id, Life]
    faults: Count = 0  # number of past faults of the scenario
    skipped: list[Count] = []  # those of them without a disk
    fenced: list[tuple[Count, Standing]] = []
    given_up: list[tuple[Count, Id, Count, str]] = []
    roster: messages.Roster = messages.Roster(0, ())
    version: Count = 0  # of the ledger
    numbered: Count = 0  # obstacles so far


@dataclass(slots=True)
class Mission:
    """The mission of one robot."""

    points: tuple[Vector, ...]  # those ahead, the present one first, m
    number: int = 0  # of the order, 0 for the scenario's goal
    patrol: bool = False
    deadline: int | None = None  # tick
    status: OrderStatus = "under way"
    tick: int = 0  # of the last change of status or point

    @property
    def ordered(self) -> bool:
        """Whether it is an unfinished order."""
        return self.number > 0 and self.status == "under way"
