"""All the lines of one robot: what it must obey now, and what it sends of them (see `negotiation`)."""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Iterable, Mapping
from typing import Final

from agents.lines.ends import Follower, Owner
from agents.lines.initial_lines import InitialLines
from agents.lines.line import ROUNDING, HalfPlane, Line
from agents.lines.negotiation.far import FarNegotiation
from agents.lines.negotiation.near import ANSWER_TICKS, NearNegotiation
from agents.lines.own_set import OwnSet
from agents.lines.placement import Disk, initial_line
from agents.lines.polygon import Polygon
from agents.lines.robot_pair import RobotPair
from agents.peers.far import FarPicture
from agents.peers.state import PeerState
from protocol.bodies.sweep import Sweep
from protocol.messages import Answer, Member, Proposal

AHEAD: Final = 20.0  # ticks of motion ahead of which initial lines are looked at
SHOWN: Final = 2048  # most obeyed lines that a monitor is told: Health has a limit


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
        berth: room that own lines leave at either side, m, as far as there is any.
        members: of the first roster that this incarnation hears, by id.
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
        berth: float = 0.0,
        members: Mapping[int, Member] = {},
        starts: Mapping[int, tuple[float, float]] | None = None,
        urgent: float | None = None,
    ) -> None:
        self._robot, self._incarnation = robot, incarnation
        self._radius, self._radii, self._starts = radii[robot], radii, starts
        self._period, max_step = period, speed * period
        self._reach = reach if reach > 0.0 else max_step
        self._first = members
        self._disturbed = False  # whether there was ever a peer without a line of its present incarnation
        self._pairs: dict[int, RobotPair] = {}
        self._each: list[RobotPair] = []  # that do not rest
        self._near_negotiation = NearNegotiation(max_step, period, berth)
        self._far_negotiation = None if urgent is None else FarNegotiation(urgent)
        self._initial: InitialLines | None = None
        if starts is not None and urgent is not None:
            self._initial = InitialLines(robot, starts, radii, AHEAD * max_step)
        for peer in sorted(radii) if self._initial is None else self._initial.unusable:
            if peer != robot:
                self._pair(peer)
        self._talking = self._each if urgent is None else []  # pairs of those who hear this robot's States
        self._near: frozenset[int] = frozenset()
        self.wanted = 0.0  # m, radius of the disk for which own lines leave room, if that is larger
        self._tick = 0
        self._own = OwnSet(0.0, 0.0, math.inf)
        for member in members.values():
            if member.robot == robot:
                continue
            founding = member.robot in radii and member.incarnation == member.founding
            if member.status != "live" or not founding:
                self.on_member(member)

    def _pair(self, peer: int) -> RobotPair:
        """All about a peer, as it was at the start unless something was said since. It rests no more."""
        pair = self._pairs.get(peer)
        if pair is not None and not pair.rests:
            return pair
        if pair is None:
            starts, founding = self._starts, peer in self._radii
            pair = self._pairs[peer] = RobotPair(
                peer,
                self._incarnation,
                owns=self._robot < peer,
                own_radius=self._radius,
                radius=self._radii[peer] if founding else 0.0,
                initial=initial_line(self._robot, peer, starts, self._radii) if starts and founding else None,
                peer_incarnation=self._first[peer].founding if founding and peer in self._first else 0,
            )
            self._disturbed = self._disturbed or not pair.end.linked
        pair.rests = False
        if self._initial is None:
            self._each.append(pair)
        else:
            insort(self._each, pair, key=_peer_of)  # as if all had been there from the beginning
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
        self._own = OwnSet(*position, bound, shape, swept)
        for pair in self._each if self._disturbed else ():
            if pair.disk is not None:
                pair.disk.renew(self._own)

    def on_state(self, state: PeerState) -> None:
        """Process what a peer's State says about the common line; old or repeated ones do no harm."""
        pair = self._pairs.get(state.robot)
        if pair is None or pair.rests:
            pair = self._pair(state.robot)
        if not pair.accept(state):
            return
        if pair.state is state:
            pair.transit = self._tick + 1 - state.tick
        if state.radius != pair.radius and pair.disk is None:
            pair.radius = state.radius
        self._disturbed = self._disturbed or not pair.end.linked
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
        self._disturbed = True
        pair.on_member(member)
        if pair.disk is not None:
            pair.disk.renew(self._own)

    def has_room(self, radius: float) -> bool:
        """Whether the own disk satisfies all it obeys if it is one of `radius`, m, around the same centre."""
        own, growth = self._own, radius - self._radius
        self._look(own.x, own.y, own.bound + self._reach + 2.0 * ROUNDING + max(0.0, growth))
        return all(own.satisfies(side, growth) for pair in self._pairs.values() for side in pair.half_planes)

    def resize(self, radius: float) -> None:
        """The own disk is one of `radius` from now on, m; a larger one only where it `has_room`."""
        self._radius = radius
        for peer in self._pairs:
            self._pair(peer).resize(radius)

    @property
    def keeps_clear(self) -> bool:
        """Whether the own disk is and stays clear of every place where a disk is to appear."""
        return not self._disturbed or all(
            pair.keeps_clear or pair.disk is None for pair in self._each if pair.excused
        )

    @property
    def ready(self) -> bool:
        """Whether every peer that is there is behind something; who is not ready must stand still."""
        if not self._disturbed:
            return True
        for pair in self._each:  # noqa: SIM110  # several times in a tick; a generator costs five times as much
            if not (pair.settled or pair.ready):
                return False
        return True

    def make_room(self, desired: tuple[float, float]) -> tuple[float, float]:
        """The desired velocity (m/s), turned away from peers whose new incarnation is too close for a
        line."""
        own, (vx, vy) = self._own, desired
        for pair in self._each if self._disturbed else ():
            if pair.end.linked:
                continue
            dx, dy = pair.crowding(own.x, own.y, own.bound)
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
        own = self._own
        x, y = own.x, own.y
        near = own.bound + 2.0 * ROUNDING + 2.0 * self._reach
        self._look(x, y, near)
        found = []
        for pair in self._each:
            if pair.settled:
                if pair.limit - pair.nx * x - pair.ny * y < near:
                    found.append(own.kept_in(pair.nx, pair.ny, pair.limit))
                continue
            for side in pair.half_planes:
                if side.slack(x, y) < near:
                    found.append(own.kept_in(side.nx, side.ny, side.limit))
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
        """Look at all lines that are looked at together, and may be less than `reach` (m) from where the own
        centre at (x, y), m, would cross them; the initial ones are of the disk that it was at the start.
        """
        if self._initial is not None:
            grown = max(0.0, self._radius - self._radii[self._robot])
            for peer in self._initial.approached(x, y, reach + grown):
                self._pair(peer)

    def obeyed_lines(self) -> tuple[tuple[int, float, float, float], ...]:
        """The obeyed lines for a monitor: peer, nx, ny, limit; the own disk keeps n.x <= limit. All of
        them, or if those are too many, the tightest of each pair."""
        pairs = sorted(self._pairs.values(), key=_peer_of)
        obeyed_lines = [(pair.peer, side) for pair in pairs for side in pair.half_planes]
        if len(obeyed_lines) > SHOWN:
            obeyed_lines.sort(key=self._slack, reverse=True)
            obeyed_lines = list(dict(obeyed_lines).items())  # the last of each pair
        return tuple((peer, side.nx, side.ny, side.limit + self._radius) for peer, side in obeyed_lines)

    def _slack(self, side: tuple[int, HalfPlane]) -> float:
        return side[1].slack(self._own.x, self._own.y)

    def entries(self, desired: tuple[float, float]) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What this tick's State says about lines; `desired` is the velocity that the law asks for, m/s."""
        standing = not self.ready
        me = self._own_disk((0.0, 0.0) if standing else desired)
        return self._near_negotiation.entries(
            self._tick, self._talking, me, self._owner_fits, standing=standing
        )

    def _own_disk(self, velocity: tuple[float, float]) -> Disk:
        """Own disk, with all that its centre may pass before commands that are out have ended."""
        own = self._own
        me = Disk(own.x, own.y, max(self._radius, self.wanted) + own.bound, *velocity)
        if own.swept is None:
            return me
        mx, my = own.swept.middle
        return Disk(me.x + mx, me.y + my, me.radius + own.swept.spread, *velocity)

    # -- where some are far

    def attend(self, near: Iterable[int]) -> None:
        """From now on States are exchanged with those who are near only; with others, letters."""
        talk = self._far_negotiation
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
        if self._initial is not None and self._initial.moved_on:
            self._initial.moved_on = False
            self._put_to_rest(self._initial, talk)

    def _put_to_rest(self, lines: InitialLines, negotiation: FarNegotiation) -> None:
        """Look one by one only at lines that somebody is near, or about which something is open."""
        for pair in self._each:
            if pair.quiet and pair.peer not in self._near and not negotiation.concerns(pair):
                side = pair.line_half_planes[0]
                theirs = side.limit + self._radius + pair.radius
                pair.rests = lines.rest(pair.peer, side, theirs)
        self._each = [pair for pair in self._each if not pair.rests]

    def survey(self, picture: FarPicture) -> None:
        """More is known of where everybody is: see to lines that this robot or a far peer may soon reach."""
        talk = self._far_negotiation
        assert talk is not None
        own = self._own
        if math.isinf(own.bound):
            return
        me = self._own_disk((0.0, 0.0))
        if self._initial is not None:
            self._look(me.x, me.y, talk.urgent + me.radius - self._radius)
            for peer in self._initial.reached(picture, talk.urgent):
                self._pair(peer)
        far = [pair for pair in self._each if pair.owns and pair.peer not in self._near]
        talk.survey(picture, me, far)

    def on_letter(self, state: PeerState) -> None:
        """Process what a far peer says of the common line."""
        self.on_state(state)
        pair = self._pairs[state.robot]
        if self._far_negotiation is None or pair.heard != state.incarnation or state.robot in self._near:
            return
        if not pair.owns:
            pair.answers_left = 1  # it asks at least who lives
            self._far_negotiation.take_up(pair)
        elif not pair.end.linked:
            self._far_negotiation.take_up(pair)

    def letters(self) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """What is to be said to far peers in this tick, as `entries` is to near ones."""
        if self._far_negotiation is None or math.isinf(self._own.bound):
            return (), ()
        return self._far_negotiation.entries(self._own_disk((0.0, 0.0)), self._owner_fits)

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

    def _owner_fits(self, line: Line) -> bool:
        return self._fits(line, owner=True)

    def _follower_fits(self, line: Line) -> bool:
        return self._fits(line, owner=False)

    def _fits(self, line: Line, owner: bool) -> bool:
        """Whether the own disk surely satisfies a line now and until every command that is out has ended."""
        return line.is_unit and self._own.satisfies(line.side(self._radius, owner))


def _peer_of(pair: RobotPair) -> int:
    return pair.peer
