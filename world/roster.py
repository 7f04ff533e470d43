"""Who takes part: which process stands for which robot, as the world sees it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from protocol.messages import Health

_RESERVATION = 2.0  # s between admission and liveliness token


@dataclass
class Seat:
    """One robot id: the process (session) that was admitted, and whether its token is there."""

    session: str = ""
    present: bool = False
    since: float = 0.0  # s, monotonic: when it was admitted
    health: Health | None = None  # what its process reported at the end of the run
    told: bool = False  # it knows that there is nothing more to do


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
        self.seats[robot].present = True

    def leave(self, robot: int) -> None:
        """The robot's liveliness token is gone: its process ended, hangs, or is cut off."""
        seat = self.seats[robot]
        seat.present, seat.session = False, ""

    def unseated(self) -> frozenset[int]:
        """Robots without an admitted process whose token is there."""
        return frozenset(r for r, seat in self.seats.items() if not (seat.present and seat.session))

    def owing_health(self) -> list[int]:
        """Present robots that have not reported at the end of the run."""
        return [robot for robot, seat in self.seats.items() if seat.present and seat.health is None]

    def untold(self) -> list[int]:
        """Present robots that do not know yet that it is over."""
        return [robot for robot, seat in self.seats.items() if seat.present and not seat.told]

    def forget_reports(self) -> None:
        """Begin a new run with the same processes."""
        for seat in self.seats.values():
            seat.health = None
