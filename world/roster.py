"""Who takes part: which process stands for which robot, as the world sees it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

from protocol.messages import Health

_RESERVATION = 2.0  # s between admission and liveliness token


@dataclass
class Seat:
    """One robot id: the process (session) that was admitted, and whether its token is there."""

    session: str = ""
    present: bool = False
    missing: float = inf  # s, monotonic: since when the token of a process that may be alive is not there
    since: float = 0.0  # s, monotonic: when it was admitted
    health: Health | None = None  # what its process reported at the end of the run
    told: bool = False  # it knows that there is nothing more to do

    @property
    def occupied(self) -> bool:
        """Whether there is a process, or may be."""
        return self.present or self.missing < inf


class Roster:
    """All seats of a fleet."""

    def __init__(self, ids: Iterable[int]) -> None:
        self.seats = {robot: Seat() for robot in ids}

    def reserve(self, robot: int, session: str, now: float) -> bool:
        """Give the seat to a process; False while another one has it, or has just been admitted."""
        seat = self.seats[robot]
        if seat.session not in ("", session) and (seat.present or now < seat.since + _RESERVATION):
            return False
        seat.session, seat.since = session, now
        return True

    def occupied_by_another(self, robot: int, session: str) -> bool:
        """Whether a different process is alive under this id."""
        seat = self.seats[robot]
        return seat.present and seat.session not in ("", session)

    def arrive(self, robot: int) -> None:
        """The robot's liveliness token is there."""
        seat = self.seats[robot]
        seat.present, seat.missing = True, inf

    def miss(self, robot: int, now: float) -> None:
        """The robot's liveliness token is gone: its process ended, hangs, or is cut off."""
        seat = self.seats[robot]
        seat.present, seat.missing = False, min(seat.missing, now)

    def leave(self, robot: int) -> None:
        """The process is taken to be gone."""
        seat = self.seats[robot]
        seat.present, seat.session, seat.missing = False, "", inf

    def missing(self, since: float = inf) -> list[int]:
        """Robots whose token has not been there since then, and whose process may yet be alive."""
        return [robot for robot, seat in self.seats.items() if seat.missing < inf and seat.missing <= since]

    def unseated(self) -> frozenset[int]:
        """Robots without an admitted process whose token is there."""
        return frozenset(r for r, seat in self.seats.items() if not (seat.present and seat.session))

    def owing_health(self) -> list[int]:
        """Robots that have not reported at the end of the run, and can."""
        return [robot for robot, seat in self.seats.items() if seat.occupied and seat.health is None]

    def untold(self) -> list[int]:
        """Robots that do not know yet that it is over, and can be told."""
        return [robot for robot, seat in self.seats.items() if seat.occupied and not seat.told]

    def forget_reports(self) -> None:
        """Begin a new run with the same processes."""
        for seat in self.seats.values():
            seat.health = None
