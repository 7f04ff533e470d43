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
from collections.abc import Callable, Iterable
from typing import Final, final

from agents.lines.ends import Owner
from agents.lines.line import Line
from agents.lines.negotiation.entries import answer_of, proposal_of
from agents.lines.placement import Disk, fit_line, is_same
from agents.lines.robot_pair import RobotPair
from agents.peers.state import PeerState
from protocol.messages import Answer, Proposal

ANSWER_TICKS: Final = 3  # an answer stands in this many States after the proposal was last heard
OUTSTANDING: Final = 32  # most unanswered proposals of one pair
RENEWALS: Final = 5  # initial lines that an owner replaces in a tick although nobody is near; see above
FOLLOWED: Final = 3.0  # periods for which a follower's way is kept free from when it adopts a line
UNCHANGED: Final = 1e-2  # of what a robot moves in a tick: a line that differs by less is not proposed


@final
class NearNegotiation:
    """When an owner offers a near peer another line, and where that lies.

    Args:
        max_step: the most that a robot really moves in a tick, m.
        period: of a tick, s.
        berth: room that a line leaves at either side, m, as far as there is any.
    """

    def __init__(self, max_step: float, period: float, berth: float = 0.0) -> None:
        self._max_step, self._period, self._berth = max_step, period, berth

    def entries(
        self, tick: int, pairs: Iterable[RobotPair], me: Disk, fits: Callable[[Line], bool], *, standing: bool
    ) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What the State of a tick says.

        Args:
            tick: of the State.
            pairs: with all who hear it.
            me: own disk, its radius with the error bound, and its desired velocity.
            fits: whether the own disk surely satisfies a line as its owner.
            standing: whether this robot cannot move: then it needs none of the gap.
        """
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        renewals = RENEWALS
        for pair in pairs:
            if pair.owns:
                renewals -= self._consider(tick, pair, me, fits, standing, renewals)
                offer = None if pair.settled else proposal_of(pair)
                if offer is not None:
                    proposals.append(offer)
            elif pair.answers_left:
                pair.answers_left -= 1
                answers.append(answer_of(pair))
        return tuple(proposals), tuple(answers)

    def _consider(
        self,
        tick: int,
        pair: RobotPair,
        me: Disk,
        fits: Callable[[Line], bool],
        standing: bool,
        renewals: int,
    ) -> int:
        """Propose a new line if the pair needs one; whoever of the two cannot move needs none of the gap.

        Returns 1 if it is one of the `renewals`, else 0.
        """
        state = pair.state
        if state is None or not state.placed:
            return 0
        ticks = max(0, tick - state.tick) + 2
        apart = 2.0 * ticks * self._max_step
        # A pair is left alone if neither comes near the line before a new one could be agreed.
        mine, theirs = apart + me.radius, apart + pair.radius + state.bound
        if (
            pair.settled
            and pair.offset - pair.nx * me.x - pair.ny * me.y > mine
            and -(pair.offset - pair.nx * state.x - pair.ny * state.y) > theirs
        ):
            return 0
        end = pair.end
        assert isinstance(end, Owner)
        if not end.met or len(end.proposed) >= OUTSTANDING:
            return 0
        newest, renewal = end.newest, 0
        if newest is not None and newest.gap(me.x, me.y) > mine and -newest.gap(state.x, state.y) > theirs:
            if end.number > 0 or renewals == 0:
                return 0
            renewal = 1
        line = self._fit_line(tick, pair, me, state, standing)
        if line is None or not fits(line):
            return 0
        if newest is None or not is_same(line, newest, UNCHANGED * self._max_step):
            end.propose(line)
            pair.renew()
        return renewal

    def _fit_line(
        self, tick: int, pair: RobotPair, me: Disk, state: PeerState, standing: bool
    ) -> Line | None:
        """The line that lets both do what they want, as far as can be told from the peer's State."""
        halted = pair.disk is not None
        # While States are lost, nobody is reckoned to go on as it did for more than its radius.
        age = max(0, min(tick - state.tick, pair.transit + math.ceil(pair.radius / self._max_step)))
        peer = Disk(state.x, state.y, pair.radius + state.bound)
        if not halted:
            (peer.vx, peer.vy), (peer.ux, peer.uy) = state.desired, self._seen_velocity(pair)
        # The follower holds a line from when it has come, as late as its State came here, until the next has.
        late = 2.0 * max(0, age - 1) * self._period
        return fit_line(
            me,
            peer,
            ahead=(age + 2) * self._period,
            begin=late,
            end=late + FOLLOWED * self._period,
            share=0.0 if standing else 1.0 if halted else 0.5,
            berth=self._berth,
        )

    def _seen_velocity(self, pair: RobotPair) -> tuple[float, float]:
        """Of the peer, from where its last two States were, m/s; measurements may leap, disks do not."""
        ux, uy = pair.moved_x, pair.moved_y
        leap = max(1.0, math.hypot(ux, uy) / self._max_step) * self._period
        return ux / leap, uy / leap
