"""What a robot says of lines to peers that hear its States.

States carry only what is open. The newest proposal is repeated in every State until it is answered. An answer
is said when a proposal was heard, in the States of the next few ticks. That suffices: an owner without an
unanswered proposal needs no answer; one that has any repeats the newest for ever, so if every answer so far
was lost, the next repetition that arrives brings about another, and that settles all older ones.

The initial line knows nothing of where the two want to go, and stays if one of them is lost. So an owner
replaces it once although neither is near, a few pairs a tick: all at once, a large fleet would begin with
messages ten times their usual size.

An owner proposes anew every tick, without waiting for the answers to earlier proposals: under delay
that halves the age of the lines, and the arrival times with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, final

from agents.lines.bond import Bond, Cover
from agents.lines.placement import Disk, fit_line, is_same
from agents.peers.state import PeerState
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.robot import LINES, Robot
from protocol.line import Line
from protocol.messages import Answer, Proposal
from protocol.region import Region

ANSWER_TICKS: Final = 3  # an answer stands in this many States after the proposal was last heard
OUTSTANDING: Final = 32  # most unanswered proposals of one pair
RENEWALS: Final = 5  # initial lines that an owner replaces in a tick although no peer is near
FOLLOWED: Final = 3.0  # periods for which a follower's way is kept free from when it adopts a line
UNCHANGED: Final = 1e-2  # of what a robot moves in a tick: a line that differs by less is not proposed


@final
class Negotiation:
    """When an owner offers a peer another line, and where that lies.

    Args:
        max_step: the most that a robot really moves in a tick, m.
        period: of a tick, s.
        standoff: room that a line leaves at either side, m, as far as there is any.
    """

    def __init__(self, max_step: float, period: float, standoff: float = 0.0) -> None:
        self._max_step, self._period, self._standoff = max_step, period, standoff

    def entries(
        self,
        tick: int,
        bonds: Iterable[Bond],
        me: Disk,
        kernel: Robot[Region, Line, Cover],
        *,
        standing: bool,
    ) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What the State of a tick says.

        Args:
            tick: of the State.
            bonds: with the present lives of peers.
            me: own disk, its radius with the error bound, and its desired velocity.
            kernel: says what fits.
            standing: whether this robot cannot move: then it needs none of the gap.
        """
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        renewals = RENEWALS
        for bond in bonds:
            lines = bond.bound.lines
            if isinstance(lines, Owner):
                renewals -= self._consider(tick, bond, lines, me, kernel, standing, renewals)
                if lines.open:
                    number, line = lines.open[-1]  # an answer to it settles all before it
                    proposals.append(
                        Proposal(bond.peer, bond.bound.number, number, line.nx, line.ny, line.offset)
                    )
            elif bond.answers_left and isinstance(lines, Follower):
                bond.answers_left -= 1
                answers.append(Answer(bond.peer, bond.bound.number, lines.held_number, lines.seen))
        return tuple(proposals), tuple(answers)

    def _consider(
        self,
        tick: int,
        bond: Bond,
        lines: Owner[Line],
        me: Disk,
        kernel: Robot[Region, Line, Cover],
        standing: bool,
        renewals: int,
    ) -> int:
        """Propose a new line if the pair needs one; an end that cannot move needs none of the gap.

        Returns 1 if it is one of the `renewals`, else 0.
        """
        state = bond.state
        if state is None or not state.placed or bond.bound.state != LINES:
            return 0
        ticks = max(0, tick - state.tick) + 2
        apart = 2.0 * ticks * self._max_step
        # A pair is left alone if neither comes near the line before a new one could be agreed.
        mine, theirs = apart + me.radius, apart + bond.radius + state.bound
        if (
            bond.settled
            and bond.offset - bond.nx * me.x - bond.ny * me.y > mine
            and -(bond.offset - bond.nx * state.x - bond.ny * state.y) > theirs
        ):
            return 0
        if len(lines.open) >= OUTSTANDING:
            return 0
        newest, renewal = (lines.open[-1][1] if lines.open else lines.held), 0
        if newest.gap(me.x, me.y) > mine and -newest.gap(state.x, state.y) > theirs:
            if lines.number > 0 or renewals == 0:
                return 0
            renewal = 1
        line = self._fit_line(tick, bond, me, state, standing)
        if line is None or not kernel.fits(bond.bound, line):
            return 0
        if not is_same(line, newest, UNCHANGED * self._max_step):
            lines.propose(line, True)
            bond.renew()
        return renewal

    def _fit_line(self, tick: int, bond: Bond, me: Disk, state: PeerState, standing: bool) -> Line | None:
        """The line that lets both do what they want, as far as can be told from the peer's State."""
        halted = bond.bound.place is not None
        # While States are lost, a peer is reckoned to go on as it did for at most its radius.
        age = max(0, min(tick - state.tick, bond.transit + math.ceil(bond.radius / self._max_step)))
        peer = Disk(state.x, state.y, bond.radius + state.bound)
        if not halted:
            (peer.vx, peer.vy), (peer.ux, peer.uy) = state.desired, self._seen_velocity(bond)
        # The follower holds a line from when it has come, as late as its State came here, until the next has.
        late = 2.0 * max(0, age - 1) * self._period
        return fit_line(
            me,
            peer,
            ahead=(age + 2) * self._period,
            begin=late,
            end=late + FOLLOWED * self._period,
            share=0.0 if standing else 1.0 if halted else 0.5,
            standoff=self._standoff,
        )

    def _seen_velocity(self, bond: Bond) -> tuple[float, float]:
        """Of the peer, from where its last two States were, m/s; measurements may leap, disks do not."""
        ux, uy = bond.moved_x, bond.moved_y
        leap = max(1.0, math.hypot(ux, uy) / self._max_step) * self._period
        return ux / leap, uy / leap
