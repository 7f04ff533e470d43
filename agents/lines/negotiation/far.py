"""What a robot says of lines to peers that it does not hear, in letters that the world hands on.

A far pair keeps to the line that it has. Its owner offers another only when one of the two may soon reach
that line, and one offer at a time. Where the peer is it knows from the last summary. What is not answered as
soon as it can be is said again; an answer is said once for each time that it is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Final, final

from agents.lines.ends import Follower, Owner
from agents.lines.line import Line
from agents.lines.negotiation.entries import answer_of, proposal_of
from agents.lines.placement import Disk, fit_line
from agents.lines.robot_pair import RobotPair
from agents.peers.far import FarPicture
from protocol.messages import Answer, Proposal, Vector

LETTERS: Final = 64  # entries that a tick's letters hold at most: a Command has a limit
_WORTH: Final = 1.25  # another line must leave so many times the gap


@final
class FarNegotiation:
    """The pairs of one robot with far peers about whose line something is to be said.

    Args:
        urgent: gap (m) to a line below which another is offered.
    """

    def __init__(self, urgent: float) -> None:
        self.urgent = urgent
        self._open: dict[int, RobotPair] = {}
        self._said: dict[int, RobotPair] = {}  # in the last tick; the answer cannot be there in the next
        self._asked: dict[int, RobotPair] = {}  # in the tick before that
        self._picture: FarPicture | None = None

    def survey(self, picture: FarPicture, me: Disk, far: Iterable[RobotPair]) -> None:
        """More is known of where everybody is; of `far` pairs, all its own, some may need another line."""
        self._picture = picture
        for pair in far:
            place = picture.place(pair.peer) if pair.disk is None else None
            if place is not None and self._gap(pair, me, place) < self.urgent:
                self.take_up(pair)

    def take_up(self, pair: RobotPair) -> None:
        """Something may have to be said to this peer."""
        self._open[pair.peer] = pair

    def concerns(self, pair: RobotPair) -> bool:
        """Whether something may have to be said to this peer."""
        return pair.peer in self._open or pair.peer in self._said or pair.peer in self._asked

    def drop(self, near: frozenset[int]) -> None:
        """These are heard; lines with them are talked about in States."""
        self._open, self._said, self._asked = (
            {peer: pair for peer, pair in pairs.items() if peer not in near}
            for pairs in (self._open, self._said, self._asked)
        )

    def entries(
        self, me: Disk, fits: Callable[[Line], bool]
    ) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What this tick's letters say; to be asked for in every tick.

        Args:
            me: own disk, its radius with the error bound.
            fits: whether the own disk surely satisfies a line as its owner.
        """
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        self._open |= self._asked
        self._asked, self._said = self._said, {}
        for peer in list(self._open)[:LETTERS]:
            pair = self._open.pop(peer)  # whoever is not done is put back, behind all others
            end = pair.end
            if pair.ready and not end.agreed and pair.heard < end.peer_incarnation:
                continue  # it stands, or is gone; if it lives again, it speaks first
            if isinstance(end, Follower):
                answers.append(answer_of(pair))
                pair.answers_left -= 1
                if pair.answers_left > 0 or not pair.ready:
                    self._said[peer] = pair
            elif not end.met:
                answers.append(Answer(peer, end.peer_incarnation, 0, 0))  # which asks for an answer
                self._said[peer] = pair
            else:
                self._consider(pair, end, me, fits)
                offer = proposal_of(pair)
                if offer is not None:
                    proposals.append(offer)
                    self._said[peer] = pair
                elif not end.linked:
                    self._open[peer] = pair
        return tuple(proposals), tuple(answers)

    def _consider(self, pair: RobotPair, end: Owner, me: Disk, fits: Callable[[Line], bool]) -> None:
        """Offer another line, if there is need and nothing else is offered."""
        place = None if self._picture is None else self._picture.place(pair.peer)
        if end.proposed or place is None:
            return
        gap = self._gap(pair, me, place)
        if gap >= self.urgent:
            return
        peer = Disk(*place, pair.radius)
        line = fit_line(me, peer)
        if line is not None and fits(line) and _gap(line, me, *place, pair.radius) > _WORTH * max(gap, 0.0):
            end.propose(line)
            pair.renew()

    def _gap(self, pair: RobotPair, me: Disk, place: Vector) -> float:
        """What the held line leaves, m; less than nothing if there is none."""
        assert isinstance(pair.end, Owner)
        held = pair.end.held
        return -math.inf if held is None else _gap(held, me, *place, pair.radius)


def _gap(line: Line, owner: Disk, x: float, y: float, radius: float) -> float:
    """The smaller of the gaps that a line leaves its owner's disk and one of `radius` at (x, y), m."""
    mine = line.gap(owner.x, owner.y) - owner.radius
    return min(mine, -line.gap(x, y) - radius)
