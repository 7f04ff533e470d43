"""All the lines of one robot: what it must obey now, what it says about them.

Messages carry only what is open. A proposal is repeated in every State until it is answered, or,
if a State has no room for all, at least the newest of the pair (`spoken.fitting`). An answer is said when
a proposal was heard, in the States of the next few ticks. That suffices: an owner without an unanswered
proposal needs no answer; one that has any repeats the newest for ever, so if every answer so far was
lost, the next repetition that arrives brings about another, and that settles all older ones.

The initial line knows nothing of where the two want to go, and stays if one of them is lost. So an owner
replaces it once although neither is near, a few pairs a tick: all at once, a large fleet would begin with
messages ten times their usual size.

An owner proposes anew every tick, without waiting for the answers to earlier proposals: under delay
that halves the age of the lines, and the arrival times with it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Final

from agents.lines.ends import Follower, Owner
from agents.lines.entries import answer_of, fitting, proposals_of
from agents.lines.line import ROUNDING, HalfPlane, Line
from agents.lines.placement import Disk, initial_line, is_same, place
from agents.lines.robot_pair import Bond
from agents.peers.state import PeerState
from agents.polygon import Polygon
from protocol.messages import Answer, Member, Proposal

ANSWER_TICKS: Final = 3  # an answer stands in this many States after the proposal was last heard
OUTSTANDING: Final = 32  # most unanswered proposals of one pair
RENEWALS: Final = 5  # initial lines that an owner replaces in a tick although nobody is near; see above
SHOWN: Final = 2048  # most obeyed lines that a monitor is told: Health has a limit
UNCHANGED: Final = 1e-2  # of what a robot moves in a tick: a line that differs by less is not proposed


class Ledger:
    """Every separating line of one robot.

    One tick is: `locate`, `hear` what has come in, `speak` for the State; `hear` the States of this
    tick, then `ready` and `half_planes` for the velocity. No command is outstanding at these moments.

    Args:
        robot: own id.
        incarnation: own life.
        radii: radius of every robot, m, own included.
        speed: the most that a robot really moves, m/s.
        period: of one tick, s.
        members: the others in the first roster that this life hears.
        starts: where every robot begins, m, if this life is a founding one.
    """

    def __init__(
        self,
        robot: int,
        incarnation: int,
        radii: Mapping[int, float],
        *,
        speed: float,
        period: float,
        members: Sequence[Member] = (),
        starts: Mapping[int, tuple[float, float]] | None = None,
    ) -> None:
        self._robot, self._incarnation = robot, incarnation
        self._radius = radii[robot]
        self._period, self._reach = period, speed * period
        founding = {each.robot: each.founding for each in members}
        self._bonds = {
            peer: self._bond(
                peer,
                radii[peer],
                None if starts is None else initial_line(robot, peer, starts, radii),
                founding.get(peer, 0),
            )
            for peer in sorted(radii)
            if peer != robot
        }
        self._each = list(self._bonds.values())
        self._disturbed = False  # whether any peer was ever fenced, or began anew
        self._tick = 0
        self._x = self._y = 0.0
        self._bound = float("inf")
        self._shape: Polygon | None = None
        for member in members:
            if member.status != "live":
                self.on_member(member)

    def _bond(self, peer: int, radius: float, initial: Line | None, peer_life: int) -> Bond:
        return Bond(
            peer,
            self._incarnation,
            owns=self._robot < peer,
            own_radius=self._radius,
            radius=radius,
            initial=initial,
            peer_life=peer_life,
        )

    def locate(
        self, tick: int, position: tuple[float, float], bound: float, shape: Polygon | None = None
    ) -> None:
        """Take the own position (m) at the start of `tick`; the truth is at most `bound` (m) from it, and
        within `shape` around it if that is given."""
        self._tick = tick
        self._x, self._y = position
        self._bound, self._shape = bound, shape
        for bond in self._each if self._disturbed else ():
            if bond.disk is not None:
                bond.disk.renew(self._x, self._y, bound, shape)

    def hear(self, state: PeerState) -> None:
        """Process what a peer's State says about the common line; old or repeated ones do no harm."""
        bond = self._each[state.place]
        if bond.peer != state.robot:
            bond = self._bonds[state.robot]
        if not bond.meet(state):
            return
        self._disturbed = self._disturbed or bond.anew
        if not state.answers and not state.proposals:
            return
        if isinstance(bond.end, Owner):
            self._hear_answers(bond, bond.end, state)
        else:
            self._hear_proposals(bond, bond.end, state)

    def on_member(self, member: Member) -> None:
        """A newer roster says something else of a peer than the one before."""
        bond = self._bonds.get(member.robot)
        if bond is None:
            bond = self._bonds[member.robot] = self._bond(member.robot, member.radius, None, 0)
            self._each.append(bond)
        self._disturbed = self._disturbed or member.status != "live"
        bond.on_member(member)
        if bond.disk is not None:
            bond.disk.renew(self._x, self._y, self._bound, self._shape)

    @property
    def keeps_clear(self) -> bool:
        """Whether the own disk is and stays clear of every place where a disk is to appear."""
        return not self._disturbed or all(
            bond.keeps_clear or bond.disk is None for bond in self._each if bond.excused
        )

    @property
    def ready(self) -> bool:
        """Whether every peer that is there is behind something; who is not ready must stand still."""
        for bond in self._each:  # noqa: SIM110  # several times in a tick; a generator costs five times as much
            if not (bond.settled or bond.ready):
                return False
        return True

    def make_room(self, desired: tuple[float, float]) -> tuple[float, float]:
        """The desired velocity (m/s), turned away from peers whose new life is too close for a line."""
        vx, vy = desired
        for bond in self._each if self._disturbed else ():
            if not bond.anew or bond.end.linked:
                continue
            dx, dy = bond.crowding(self._x, self._y, self._bound)
            lacking = math.hypot(dx, dy)
            if lacking > 0.0:
                nx, ny = dx / lacking, dy / lacking
                more = max(0.0, lacking / self._period - nx * vx - ny * vy)
                vx, vy = vx + more * nx, vy + more * ny
        return vx, vy

    def half_planes(self) -> list[HalfPlane]:
        """Where the estimated own centre must stay; radius and extent of the own set are subtracted.

        Without those that are out of reach within a tick.
        """
        x, y = self._x, self._y
        near = self._bound + 2.0 * ROUNDING + 2.0 * self._reach
        found = []
        for bond in self._each:
            if bond.settled:
                if bond.limit - bond.nx * x - bond.ny * y < near:
                    margin = self._extent(bond.nx, bond.ny) + 2.0 * ROUNDING
                    found.append(HalfPlane(bond.nx, bond.ny, bond.limit - margin))
                continue
            for side in bond.half_planes:
                if side.slack(x, y) < near:
                    margin = self._extent(side.nx, side.ny) + 2.0 * ROUNDING
                    found.append(HalfPlane(side.nx, side.ny, side.limit - margin))
        return found

    def crossed(self, x: float, y: float, shape: Polygon) -> list[tuple[int, HalfPlane]]:
        """Obeyed half-planes, by peer, that a set around (x, y) sticks out of. The truth does not."""
        radius = shape.radius
        return [
            (bond.peer, side)
            for bond in self._each
            for side in bond.half_planes
            if side.slack(x, y) < radius and side.slack(x, y) < shape.extent(side.nx, side.ny)
        ]

    def _extent(self, nx: float, ny: float) -> float:
        """How far the own set reaches from the own position in the direction (nx, ny), m."""
        return self._bound if self._shape is None else self._shape.extent(nx, ny)

    def sides(self) -> tuple[tuple[int, float, float, float], ...]:
        """The obeyed lines for a monitor: peer, nx, ny, limit; the own disk keeps n.x <= limit. All of
        them, or if those are too many, the tightest of each pair."""
        sides = [(bond.peer, side) for bond in self._each for side in bond.half_planes]
        if len(sides) > SHOWN:
            sides.sort(key=self._slack, reverse=True)
            sides = list(dict(sides).items())  # the last of each pair
        return tuple((peer, side.nx, side.ny, side.limit + self._radius) for peer, side in sides)

    def _slack(self, side: tuple[int, HalfPlane]) -> float:
        return side[1].slack(self._x, self._y)

    def speak(self, desired: tuple[float, float]) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What this tick's State says about lines; `desired` is the velocity that the law asks for, m/s."""
        standing = not self.ready
        vx, vy = (0.0, 0.0) if standing else desired
        me = Disk(self._x, self._y, self._radius + self._bound, vx, vy)
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        renewals = RENEWALS
        for bond in self._each:
            if bond.owns:
                renewals -= self._consider(bond, me, standing, renewals)
                if not bond.settled:
                    proposals += proposals_of(bond)
            elif bond.answers_left:
                bond.answers_left -= 1
                answers.append(answer_of(bond))
        return tuple(fitting(proposals, len(answers))), tuple(answers)

    def _hear_answers(self, bond: Bond, end: Owner, state: PeerState) -> None:
        life = state.incarnation
        for answer in state.answers:
            if end.hear(life, answer.peer_incarnation, answer.held, answer.seen):
                bond.renew()

    def _hear_proposals(self, bond: Bond, end: Follower, state: PeerState) -> None:
        life = state.incarnation
        for offer in state.proposals:
            bond.answers_left = ANSWER_TICKS
            line = Line(offer.nx, offer.ny, offer.offset)
            if end.hear(life, offer.peer_incarnation, offer.number, line, self._follower_fits):
                bond.renew()

    def _follower_fits(self, line: Line) -> bool:
        return self._fits(line, owner=False)

    def _fits(self, line: Line, owner: bool) -> bool:
        """Whether the own disk surely satisfies a line now."""
        side = line.side(self._radius, owner)
        return line.is_unit and side.slack(self._x, self._y) >= self._extent(side.nx, side.ny) + ROUNDING

    def _consider(self, bond: Bond, me: Disk, standing: bool, renewals: int) -> int:
        """Propose a new line if the pair needs one; whoever of the two cannot move needs none of the gap.

        Returns 1 if it is one of the `renewals`, else 0.
        """
        state = bond.state
        if state is None or not state.placed:
            return 0
        ticks = max(0, self._tick - state.tick) + 2
        apart = 2.0 * ticks * self._reach
        # A pair is left alone if neither comes near the line before a new one could be agreed.
        mine, theirs = apart + me.radius, apart + bond.radius + state.bound
        if (
            bond.settled
            and bond.offset - bond.nx * me.x - bond.ny * me.y > mine
            and -(bond.offset - bond.nx * state.x - bond.ny * state.y) > theirs
        ):
            return 0
        end = bond.end
        assert isinstance(end, Owner)
        if not end.met or len(end.proposed) >= OUTSTANDING:
            return 0
        newest, renewal = end.newest, 0
        if newest is not None and newest.gap(me.x, me.y) > mine and -newest.gap(state.x, state.y) > theirs:
            if end.number > 0 or renewals == 0:
                return 0
            renewal = 1
        halted = bond.disk is not None
        vx, vy = (0.0, 0.0) if halted else state.desired
        peer = Disk(state.x, state.y, bond.radius + state.bound, vx, vy)
        line = place(me, peer, ticks * self._period, 0.0 if standing else 1.0 if halted else 0.5)
        if line is None or not self._fits(line, owner=True):
            return 0
        if newest is None or not is_same(line, newest, UNCHANGED * self._reach):
            end.propose(line)
            bond.renew()
        return renewal
