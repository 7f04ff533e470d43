"""What stands for a robot on a track: the real known roster and ledger of one incarnation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from protocol.messages import Roster, State
from tests.agents.lines.models.product import Product

if TYPE_CHECKING:
    from tests.agents.lines.models.track import Setting

STILL = (0.0, 0.0)


@dataclass(slots=True)
class Seat:
    """One incarnation of one robot."""

    robot: int
    incarnation: int
    known: Any  # its KnownRoster
    ledger: Any = None  # none before it has heard a roster

    def speak(self, product: Product, setting: Setting, choose: Callable[[int], Any]) -> State:
        """The State that it publishes; `choose` gives the line that is placed between it and each peer."""
        for pair in self.ledger._each:
            pair.answers_left = int(bool(not pair.owns and pair.end.seen))  # an answer may be said ever again
        placement = product.placement
        fit, placement.fit_line = placement.fit_line, lambda _, peer, **__: choose(round(peer.y))
        try:
            proposals, answers = self.ledger.entries(STILL)
        finally:
            placement.fit_line = fit
        name = (0.0, float(self.robot))  # no place, which only matters to where lines are placed
        return State(
            self.robot,
            self.incarnation,
            0,
            name,
            setting.bound,
            0.0,
            0.0,
            STILL,
            proposals=proposals,
            answers=answers,
        )

    def follow(
        self, roster: Roster, product: Product, setting: Setting, estimate: tuple[float, float] | None
    ) -> None:
        """Hear a version of the roster; the first makes its ledger, with `estimate` of where it is, m."""
        news = self.known.update(roster)
        if self.ledger is not None:
            for member in news:
                self.ledger.on_member(member)
            return
        starts = {robot: (start, 0.0) for robot, start in setting.starts.items()}
        self.ledger = product.SeparatingLines(
            self.robot,
            self.incarnation,
            dict.fromkeys(setting.starts, setting.radius),
            speed=4.0 * setting.length,
            period=1.0,
            members=self.known.members,
            starts=starts if self.known.founding else None,
        )
        if estimate is not None:
            self.ledger.locate(0, estimate, setting.bound)
