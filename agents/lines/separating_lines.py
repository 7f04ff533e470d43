"""All the lines of one robot: what it must obey now, what it says about them.

Messages carry only what is open. A proposal is repeated in every State until it is answered, or,
if a State has no room for all, at least the newest of the pair (`entries.fitting`). An answer is said when
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
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from agents.lines.ends import Follower, Owner
from agents.lines.entries import answer_of, fitting, proposals_of
from agents.lines.far_talk import FarTalk
from agents.lines.initial_lines import InitialLines
from agents.lines.line import ROUNDING, HalfPlane, Line
from agents.lines.placement import Disk, fit_line, initial_line, is_same
from agents.lines.robot_pair import RobotPair
from agents.peers.far import FarPicture
from agents.peers.state import PeerState
from agents.polygon import Polygon
from protocol.bodies.sweep import Sweep
from protocol.messages import Answer, Member, Proposal

ANSWER_TICKS: Final = 3  # an answer stands in this many States after the proposal was last heard
OUTSTANDING: Final = 32  # most unanswered proposals of one pair
RENEWALS: Final = 5  # initial lines that an owner replaces in a tick although nobody is near; see above
FOLLOWED: Final = 3.0  # periods for which a follower's way is kept free from when it adopts a line
AHEAD: Final = 20.0  # ticks of motion ahead of which initial lines are looked at
SHOWN: Final = 2048  # most obeyed lines that a monitor is told: Health has a limit
UNCHANGED: Final = 1e-2  # of what a robot moves in a tick: a line that differs by less is not proposed


class SeparatingLines:
    """Every separating line of one robot.

    One tick is: `locate`, `on_state` for what has come in, `entries` for the State; `on_state` for the
    States of this tick, then `ready` and `half_planes` for the velocity. No command is outstanding at these
    moments.

    Args:
        robot: own id.
        incarnation: own incarnation.
        radii: radius of every robot, m, own included.
        speed: the most that a robot really moves, m/s.
        period: of one tick, s.
        reach: the longest way from the beginning of a tick until the body stands, m; unless given, that of a
            tick at full speed.
        members: the others in the first roster that this incarnation hears.
        starts: where every robot begins, m, if this incarnation is a founding one.
        urgent: gap (m) to a line below which a far peer is offered another; None where nobody is far. Then
            initial lines are looked at one by one only when somebody may come near them.
    """

    def __init__(
        self,
        robot: int,
        incarnation: int,
        radii: Mapping[int, float],
        *,
        speed: float,
        period: float,
        reach: float = 0.0,
        members: Sequence[Member] = (),
        starts: Mapping[int, tuple[float, float]] | None = None,
        urgent: float | None = None,
    ) -> None:
        self._robot, self._incarnation = robot, incarnation
        self._radius, self._radii, self._starts = radii[robot], radii, starts
        self._period, self._max_step = period, speed * period
        self._reach = reach if reach > 0.0 else self._max_step
        self._founding = {each.robot: each.founding for each in members}
        self._pairs: dict[int, RobotPair] = {}
        self._each: list[RobotPair] = []
        self._far_talk = None if urgent is None else FarTalk(urgent)
        self._initial = None if starts is None or urgent is None else InitialLines(robot, starts, radii)
        self._looked_x = self._looked_y = 0.0
        self._looked = -1.0  # gap (m) up to which initial lines were looked at there
        for peer in sorted(radii) if self._initial is None else self._initial.unusable:
            if peer != robot:
                self._pair(peer)
        self._talking = self._each if urgent is None else []  # pairs of those who hear this robot's States
        self._near: frozenset[int] = frozenset()
        self._disturbed = False  # whether any peer was ever fenced, or began anew
        self.wanted = 0.0  # m, radius of the disk for which own lines leave room, if that is larger
        self._tick = 0
        self._x = self._y = 0.0
        self._bound = float("inf")
        self._shape: Polygon | None = None
        self._swept: Sweep | None = None
        for member in members:
            founding = member.robot in radii and member.incarnation == member.founding
            if member.status != "live" or not founding:
                self.on_member(member)

    def _pair(self, peer: int) -> RobotPair:
        """All about a peer, as it was at the start unless something was said since."""
        pair = self._pairs.get(peer)
        if pair is None:
            starts, founding = self._starts, peer in self._radii
            pair = self._pairs[peer] = RobotPair(
                peer,
                self._incarnation,
                owns=self._robot < peer,
                own_radius=self._radius,
                radius=self._radii[peer] if founding else 0.0,
                initial=initial_line(self._robot, peer, starts, self._radii) if starts and founding else None,
                peer_incarnation=self._founding.get(peer, 0) if founding else 0,
            )
            self._each.append(pair)
            if self._initial is not None:
                self._each.sort(key=_peer_of)  # as if all had been there from the beginning
                self._initial.leave(peer)
        return pair

    def locate(
        self,
        tick: int,
        position: tuple[float, float],
        bound: float,
        shape: Polygon | None = None,
        swept: Sweep | None = None,
    ) -> None:
        """Take the own position (m) at the start of `tick`; the truth is at most `bound` (m) from it, and
        within `shape` around it if that is given. From there it passes `swept` until all commands that are
        still out have ended."""
        self._tick = tick
        self._x, self._y = position
        self._bound, self._shape, self._swept = bound, shape, swept
        for pair in self._each if self._disturbed else ():
            if pair.disk is not None:
                pair.disk.renew(self._x, self._y, bound, shape, swept=swept)

    def on_state(self, state: PeerState) -> None:
        """Process what a peer's State says about the common line; old or repeated ones do no harm."""
        pair = self._pairs.get(state.robot) or self._pair(state.robot)
        if not pair.accept(state):
            return
        if state.radius != pair.radius and pair.disk is None:
            pair.radius = state.radius
        self._disturbed = self._disturbed or pair.peer_restarted
        if not state.answers and not state.proposals:
            return
        if isinstance(pair.end, Owner):
            self._on_answers(pair, pair.end, state)
        else:
            self._on_proposals(pair, pair.end, state)

    def on_member(self, member: Member) -> None:
        """A newer roster says something else of a peer than the one before."""
        if member.robot not in self._pairs and member.robot not in self._radii:
            self._pair(member.robot).radius = member.radius
        pair = self._pair(member.robot)
        self._disturbed = self._disturbed or member.status != "live"
        pair.on_member(member)
        if pair.disk is not None:
            pair.disk.renew(self._x, self._y, self._bound, self._shape, swept=self._swept)

    def has_room(self, radius: float) -> bool:
        """Whether the own disk satisfies all it obeys if it is one of `radius`, m, around the same centre."""
        growth = radius - self._radius
        return all(
            side.slack(self._x, self._y) - growth >= self._passed(side) + ROUNDING
            for pair in self._each
            for side in pair.half_planes
        )

    def resize(self, radius: float) -> None:
        """The own disk is one of `radius` from now on, m; a larger one only where it `has_room`."""
        self._radius = radius
        for pair in self._each:
            pair.resize(radius)

    def _passed(self, side: HalfPlane) -> float:
        """How far the own set, and all that it passes, reaches beyond the own position towards a side, m."""
        extent = self._extent(side.nx, side.ny)
        if self._swept is not None:
            extent += self._swept.extent(side.nx, side.ny)
        return extent

    @property
    def keeps_clear(self) -> bool:
        """Whether the own disk is and stays clear of every place where a disk is to appear."""
        return not self._disturbed or all(
            pair.keeps_clear or pair.disk is None for pair in self._each if pair.excused
        )

    @property
    def ready(self) -> bool:
        """Whether every peer that is there is behind something; who is not ready must stand still."""
        for pair in self._each:  # noqa: SIM110  # several times in a tick; a generator costs five times as much
            if not (pair.settled or pair.ready):
                return False
        return True

    def make_room(self, desired: tuple[float, float]) -> tuple[float, float]:
        """The desired velocity (m/s), turned away from peers whose new incarnation is too close for a
        line."""
        vx, vy = desired
        for pair in self._each if self._disturbed else ():
            if not pair.peer_restarted or pair.end.linked:
                continue
            dx, dy = pair.crowding(self._x, self._y, self._bound)
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
        self._look(x, y, near)
        found = []
        for pair in self._each:
            if pair.settled:
                if pair.limit - pair.nx * x - pair.ny * y < near:
                    margin = self._extent(pair.nx, pair.ny) + 2.0 * ROUNDING
                    found.append(HalfPlane(pair.nx, pair.ny, pair.limit - margin))
                continue
            for side in pair.half_planes:
                if side.slack(x, y) < near:
                    margin = self._extent(side.nx, side.ny) + 2.0 * ROUNDING
                    found.append(HalfPlane(side.nx, side.ny, side.limit - margin))
        return found

    def crossed(self, x: float, y: float, shape: Polygon) -> list[tuple[int, HalfPlane]]:
        """Obeyed half-planes, by peer, that a set around (x, y) sticks out of. The truth does not."""
        radius = shape.radius
        self._look(x, y, radius)
        return [
            (pair.peer, side)
            for pair in self._each
            for side in pair.half_planes
            if side.slack(x, y) < radius and side.slack(x, y) < shape.extent(side.nx, side.ny)
        ]

    def _look(self, x: float, y: float, reach: float) -> None:
        """Look at all initial lines that may be less than `reach` (m) from the own centre at (x, y), m. None
        of the others is, as long as the centre has not moved by what they were farther off."""
        if self._initial is None or not len(self._initial):
            return
        if math.hypot(x - self._looked_x, y - self._looked_y) + reach <= self._looked:
            return
        self._looked_x, self._looked_y, self._looked = x, y, reach + AHEAD * self._max_step
        for peer in self._initial.within(x, y, self._looked):
            self._pair(peer)

    def _extent(self, nx: float, ny: float) -> float:
        """How far the own set reaches from the own position in the direction (nx, ny), m."""
        return self._bound if self._shape is None else self._shape.extent(nx, ny)

    def obeyed_lines(self) -> tuple[tuple[int, float, float, float], ...]:
        """The obeyed lines for a monitor: peer, nx, ny, limit; the own disk keeps n.x <= limit. All of
        them, or if those are too many, the tightest of each pair."""
        obeyed_lines = [(pair.peer, side) for pair in self._each for side in pair.half_planes]
        if len(obeyed_lines) > SHOWN:
            obeyed_lines.sort(key=self._slack, reverse=True)
            obeyed_lines = list(dict(obeyed_lines).items())  # the last of each pair
        return tuple((peer, side.nx, side.ny, side.limit + self._radius) for peer, side in obeyed_lines)

    def _slack(self, side: tuple[int, HalfPlane]) -> float:
        return side[1].slack(self._x, self._y)

    def entries(self, desired: tuple[float, float]) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What this tick's State says about lines; `desired` is the velocity that the law asks for, m/s."""
        standing = not self.ready
        me = self._own_disk((0.0, 0.0) if standing else desired)
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        renewals = RENEWALS
        for pair in self._talking:
            if pair.owns:
                renewals -= self._consider(pair, me, standing, renewals)
                if not pair.settled:
                    proposals += proposals_of(pair)
            elif pair.answers_left:
                pair.answers_left -= 1
                answers.append(answer_of(pair))
        return tuple(fitting(proposals, len(answers))), tuple(answers)

    def _own_disk(self, velocity: tuple[float, float]) -> Disk:
        """Own disk, with all that its centre may pass before commands that are out have ended."""
        me = Disk(self._x, self._y, max(self._radius, self.wanted) + self._bound, *velocity)
        if self._swept is None:
            return me
        mx, my = self._swept.middle
        return Disk(me.x + mx, me.y + my, me.radius + self._swept.spread, *velocity)

    # -- where some are far

    def attend(self, near: Iterable[int]) -> None:
        """From now on States are exchanged with those who are near only; with others, letters."""
        talk = self._far_talk
        assert talk is not None
        self._talking = [self._pair(peer) for peer in near if peer in self._radii or peer in self._pairs]
        self._near = frozenset(near)
        talk.drop(self._near)
        for pair in self._each:
            if pair.peer in self._near:
                continue
            pair.state = None
            owner = pair.end if isinstance(pair.end, Owner) else None
            if not pair.ready or pair.answers_left or (owner is not None and owner.proposed):
                talk.take_up(pair)

    def survey(self, picture: FarPicture) -> None:
        """More is known of where everybody is: see to lines that this robot or a far peer may soon reach."""
        talk = self._far_talk
        assert talk is not None
        if math.isinf(self._bound):
            return
        if self._initial is not None:
            self._look(self._x, self._y, talk.urgent + self._bound)
            for peer in self._initial.reached(picture, talk.urgent):
                self._pair(peer)
        far = [pair for pair in self._each if pair.owns and pair.peer not in self._near]
        talk.survey(picture, self._own_disk((0.0, 0.0)), far)

    def on_letter(self, state: PeerState) -> None:
        """Process what a far peer says of the common line."""
        self.on_state(state)
        pair = self._pairs[state.robot]
        if self._far_talk is None or pair.heard != state.incarnation or state.robot in self._near:
            return
        if not pair.owns:
            pair.answers_left = 1  # it asks at least who lives
            self._far_talk.take_up(pair)
        elif not pair.end.linked:
            self._far_talk.take_up(pair)

    def letters(self) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What is to be said to far peers in this tick, as `entries` is to near ones."""
        if self._far_talk is None or math.isinf(self._bound):
            return (), ()
        return self._far_talk.entries(self._own_disk((0.0, 0.0)), self._owner_fits)

    # -- what is said

    def _on_answers(self, pair: RobotPair, end: Owner, state: PeerState) -> None:
        incarnation = state.incarnation
        for answer in state.answers:
            if end.on_answer(incarnation, answer.peer_incarnation, answer.held, answer.seen):
                pair.renew()

    def _on_proposals(self, pair: RobotPair, end: Follower, state: PeerState) -> None:
        incarnation = state.incarnation
        for offer in state.proposals:
            pair.answers_left = ANSWER_TICKS
            line = Line(offer.nx, offer.ny, offer.offset)
            if end.on_proposal(incarnation, offer.peer_incarnation, offer.number, line, self._follower_fits):
                pair.renew()

    def _seen_velocity(self, pair: RobotPair) -> tuple[float, float]:
        """Of the peer, from where its last two States were, m/s; measurements may leap, disks do not."""
        ux, uy = pair.moved_x, pair.moved_y
        leap = max(1.0, math.hypot(ux, uy) / self._max_step) * self._period
        return ux / leap, uy / leap

    def _owner_fits(self, line: Line) -> bool:
        return self._fits(line, owner=True)

    def _follower_fits(self, line: Line) -> bool:
        return self._fits(line, owner=False)

    def _fits(self, line: Line, owner: bool) -> bool:
        """Whether the own disk surely satisfies a line now and until every command that is out has ended."""
        side = line.side(self._radius, owner)
        return line.is_unit and side.slack(self._x, self._y) >= self._passed(side) + ROUNDING

    def _consider(self, pair: RobotPair, me: Disk, standing: bool, renewals: int) -> int:
        """Propose a new line if the pair needs one; whoever of the two cannot move needs none of the gap.

        Returns 1 if it is one of the `renewals`, else 0.
        """
        state = pair.state
        if state is None or not state.placed:
            return 0
        ticks = max(0, self._tick - state.tick) + 2
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
        halted = pair.disk is not None
        peer = Disk(state.x, state.y, pair.radius + state.bound)
        if not halted:
            (peer.vx, peer.vy), (peer.ux, peer.uy) = state.desired, self._seen_velocity(pair)
        # The follower holds a line from when it has come, as late as its State came here, until the next has.
        late = 2.0 * max(0, self._tick - state.tick - 1) * self._period
        line = fit_line(
            me,
            peer,
            ahead=ticks * self._period,
            begin=late,
            end=late + FOLLOWED * self._period,
            share=0.0 if standing else 1.0 if halted else 0.5,
        )
        if line is None or not self._fits(line, owner=True):
            return 0
        if newest is None or not is_same(line, newest, UNCHANGED * self._max_step):
            end.propose(line)
            pair.renew()
        return renewal


def _peer_of(pair: RobotPair) -> int:
    return pair.peer
