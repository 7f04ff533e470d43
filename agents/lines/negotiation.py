"""Proposals and answers: which line an owner proposes, and the entries about lines in a robot's State.

No choice here is unsafe: an owner proposes only lines that its own body satisfies, and a follower adopts only
those that its own body satisfies.

A State carries the newest unanswered proposal of each pair. A follower answers a proposal in the next few
States; if all these are lost, the owner's next repetition causes another answer, which settles all older
proposals. An owner proposes every tick, without waiting for answers: under delay that halves the age of the
lines, and the arrival times with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, TypeAlias, final

from mypy_extensions import mypyc_attr

from agents.lines.own_set import Cover
from agents.peers.state import PeerState
from protocol.geometry import Shape
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.robot import ASKED, LINES, OwnEnd, RobotLife
from protocol.line import ROUNDING, SURE, HalfPlane, Line
from protocol.messages import Answer, FirstLine, Proposal, Vector
from protocol.region import Region

Kernel: TypeAlias = "RobotLife[Region, Line, Cover]"
ClosestPoints = tuple[Vector, Vector]  # closest points of two segments

_BISECTIONS: Final = 8
_NEED: Final = 4.0 * ROUNDING  # gap that a line needs, m
_MOST: Final = 0.99  # largest share of a gap for standoffs
ANSWER_TICKS: Final = 3  # States that carry an answer after the last copy of the proposal
OUTSTANDING: Final = 32  # largest number of unanswered proposals of a pair
FOLLOWED: Final = 3.0  # periods of a follower's motion that a line leaves free after its adoption
UNCHANGED: Final = 1e-2  # least difference of a new proposal, longest motions in a tick


@final
@mypyc_attr(acyclic=True)
class MovingDisk:
    """One robot, for the owner of a line: centre, radius and error bound (m), desired velocity (vx, vy), and
    last known velocity (ux, uy).
    """

    def __init__(
        self,
        x: float,
        y: float,
        radius: float,
        vx: float = 0.0,
        vy: float = 0.0,
        ux: float = 0.0,
        uy: float = 0.0,
    ) -> None:
        self.x, self.y, self.radius = x, y, radius
        self.vx, self.vy, self.ux, self.uy = vx, vy, ux, uy


def is_same(one: Line, other: Line, tolerance: float) -> bool:
    """Whether two lines differ by less than `tolerance` (m, and per metre along the line)."""
    return (
        abs(one.nx - other.nx) < tolerance
        and abs(one.ny - other.ny) < tolerance
        and abs(one.offset - other.offset) < tolerance
    )


def fit_line(
    owner: MovingDisk,
    follower: MovingDisk,
    *,
    ahead: float = 0.0,
    begin: float = 0.0,
    end: float = 0.0,
    share: float = 0.5,
    standoff: float = 0.0,
) -> Line | None:
    """The line that permits the desired motion of both for the longest time.

    The owner obeys it at once: its disk sweeps along its desired velocity for `ahead` seconds. The follower
    obeys it from `begin` to `end` seconds after its State: its disk sweeps from where its seen velocity has
    taken it by then to where its desired velocity leads. The line separates the two swept areas, and leaves
    the owner `share` of the gap between them. If they meet, all times are shortened by one factor, so two
    that drive at each other share the gap in proportion to what each wants of it. Either keeps a `standoff`,
    m, the owner first: where the gap seen is less than two, one at least can make room. A line in the middle
    separates disks whose gap is narrower than what lines take.

    None if the disks overlap by their States, and also after the desired motion.
    """
    gap = math.hypot(follower.x - owner.x, follower.y - owner.y) - owner.radius - follower.radius
    room = max(0.0, _MOST * (gap - _NEED))
    mine, theirs, least = min(standoff, room), min(standoff, max(0.0, room - standoff)), _NEED
    need = owner.radius + follower.radius + least + mine + theirs
    span = _closest(owner, follower, ahead, begin, end)
    if _length(span) < need:
        span = _closest(owner, follower, 0.0, 0.0, 0.0)
        if _length(span) < need:
            mine, least, share, need = 0.0, 0.0, 0.5, owner.radius + follower.radius
            if _length(span) < need + 2.0 * SURE:
                return None
        else:
            low, high = 0.0, 1.0
            for _ in range(_BISECTIONS):
                middle = 0.5 * (low + high)
                longer = _closest(owner, follower, middle * ahead, middle * begin, middle * end)
                if _length(longer) < need:
                    high = middle
                else:
                    low, span = middle, longer
    (ax, ay), (bx, by) = span
    length = _length(span)
    nx, ny = (bx - ax) / length, (by - ay) / length
    edge = nx * ax + ny * ay + owner.radius + 0.5 * least + mine
    return Line(nx, ny, edge + share * (length - need))


def _length(span: ClosestPoints) -> float:
    return math.hypot(span[1][0] - span[0][0], span[1][1] - span[0][1])


def _closest(one: MovingDisk, other: MovingDisk, ahead: float, begin: float, end: float) -> ClosestPoints:
    """Closest points of the paths of the two centres in `fit_line`."""
    px, py, ux, uy = one.x, one.y, one.vx * ahead, one.vy * ahead
    qx, qy = other.x + other.ux * begin, other.y + other.uy * begin
    vx, vy = other.vx * end - other.ux * begin, other.vy * end - other.uy * begin
    wx, wy = qx - px, qy - py
    cross = ux * vy - uy * vx
    if cross != 0.0:
        s, t = (wx * vy - wy * vx) / cross, (wx * uy - wy * ux) / cross
        if 0.0 <= s <= 1.0 and 0.0 <= t <= 1.0:
            point = (px + s * ux, py + s * uy)
            return point, point
    uu, vv = ux * ux + uy * uy, vx * vx + vy * vy
    shortest, nearest = math.inf, ((px, py), (qx, qy))
    for s, t in (
        (_clamped(wx * ux + wy * uy, uu), 0.0),
        (_clamped((wx + vx) * ux + (wy + vy) * uy, uu), 1.0),
        (0.0, _clamped(-wx * vx - wy * vy, vv)),
        (1.0, _clamped((ux - wx) * vx + (uy - wy) * vy, vv)),
    ):
        span = ((px + s * ux, py + s * uy), (qx + t * vx, qy + t * vy))
        length = _length(span)
        if length < shortest:
            shortest, nearest = length, span
    return nearest


def _clamped(part: float, whole: float) -> float:
    if part <= 0.0:
        return 0.0
    return 1.0 if part >= whole else part / whole


def tangent(shape: Shape, x: float, y: float, low: bool, near: float) -> Line | None:
    """The line between (x, y), m, and a static shape, of which the disk around it counts if that is more than
    `near` (m) away; None if (x, y) is in it. `low`: whether the robot is the low end of the binding."""
    around = shape.around
    dx, dy = around.x - x, around.y - y
    distance = math.hypot(dx, dy)
    target: Shape = around
    if shape is not around and distance - around.radius <= near:
        target = shape
        px, py = shape.nearest(x, y)
        dx, dy = px - x, py - y
        distance = math.hypot(dx, dy)
    if distance == 0.0:
        return None
    nx, ny = dx / distance, dy / distance
    edge = -target.support(-nx, -ny)
    return Line(nx, ny, edge) if low else Line(-nx, -ny, -edge)


def deficit(shape: Shape, x: float, y: float, room: float) -> Vector:
    """How far to back off from (x, y), m, to be `room` (m) from a static shape."""
    px, py = shape.nearest(x, y)
    if px == x and py == y:
        px, py = shape.around.x, shape.around.y
    dx, dy = x - px, y - py
    distance = math.hypot(dx, dy)
    deficit = room - shape.distance(x, y)
    if deficit <= 0.0:
        return 0.0, 0.0
    if distance == 0.0:
        return deficit, 0.0
    return deficit * dx / distance, deficit * dy / distance


@final
class Bond:
    """One binding: the kernel's own end, and what follows from it."""

    def __init__(self, end: OwnEnd[Region, Line], own_radius: float, state: PeerState | None) -> None:
        self.end, self.peer = end, end.peer
        self.own_radius = own_radius  # of the disk that keeps to it, m
        self.state = state  # newest one of the peer
        self.answers_left = 0  # States that still have to carry the answer
        self.first: FirstLine | None = None  # found, and not in the ledger yet
        self.half_planes: list[HalfPlane] = []  # constraints on the own centre
        self.renew()

    def renew(self) -> None:
        """Update the half-planes after a change of the obeyed lines."""
        self.half_planes = [line.side(self.own_radius, self.end.low) for line in self.end.obeyed]

    @property
    def is_asked(self) -> bool:
        """Whether this end is asked for the first line."""
        return self.end.state == ASKED

    def resize(self, own_radius: float) -> None:
        """Change the radius of the own disk."""
        self.own_radius = own_radius
        self.renew()


@final
class Negotiation:
    """Decides when an owner proposes a line, and which.

    Args:
        max_step: longest motion of a robot in a tick, m.
        period: of a tick, s.
        standoff: room that a line leaves on either side, m, if there is enough.
    """

    def __init__(self, max_step: float, period: float, standoff: float = 0.0) -> None:
        self._max_step, self._period, self._standoff = max_step, period, standoff

    def entries(
        self, tick: int, bonds: Iterable[Bond], me: MovingDisk, kernel: Kernel, *, standing: bool
    ) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """Proposals and answers for the State of a tick, by the bonds with the present lives of peers.

        Args:
            me: own disk, its radius with the error bound, and its desired velocity.
            standing: whether this robot cannot move: then it needs none of the gap.
        """
        proposals: list[Proposal] = []
        answers: list[Answer] = []
        for bond in bonds:
            lines = bond.end.lines
            if isinstance(lines, Owner):
                self._consider(tick, bond, lines, me, kernel, standing)
                if lines.open:
                    number, line = lines.open[-1]  # an answer covers all earlier ones
                    proposals.append(
                        Proposal(bond.peer, bond.end.number, number, line.nx, line.ny, line.offset)
                    )
            elif bond.answers_left and isinstance(lines, Follower):
                bond.answers_left -= 1
                answers.append(Answer(bond.peer, bond.end.number, lines.held_number, lines.seen))
        return tuple(proposals), tuple(answers)

    def _consider(
        self, tick: int, bond: Bond, lines: Owner[Line], me: MovingDisk, kernel: Kernel, standing: bool
    ) -> None:
        state = bond.state
        if state is None or not state.placed or bond.end.state != LINES or len(lines.open) >= OUTSTANDING:
            return
        ticks = max(0, tick - state.tick) + 2
        apart = 2.0 * ticks * self._max_step
        # No new line while neither disk can reach the present one before another is adopted.
        mine, theirs = apart + me.radius, apart + state.radius + state.bound
        newest = lines.open[-1][1] if lines.open else lines.held
        if newest.gap(me.x, me.y) > mine and -newest.gap(state.x, state.y) > theirs:
            return
        line = self._fit_line(tick, bond, me, state, standing)
        if line is None or is_same(line, newest, UNCHANGED * self._max_step):
            return
        fits = kernel.fits(bond.end, line)
        if fits:
            lines.propose(line, fits)
            bond.renew()

    def _fit_line(
        self, tick: int, bond: Bond, me: MovingDisk, state: PeerState, standing: bool
    ) -> Line | None:
        """The line that permits the desired motion of both, by the peer's State."""
        halted = bond.end.place is not None
        # While States are lost, a peer is extrapolated by at most its radius.
        age = max(0, min(tick - state.tick, state.transit + math.ceil(state.radius / self._max_step)))
        peer = MovingDisk(state.x, state.y, state.radius + state.bound)
        if not halted:
            (peer.vx, peer.vy), (peer.ux, peer.uy) = state.desired, self._seen_velocity(state)
        # The follower obeys the line from its arrival, as late as the State was, until the next arrives.
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

    def _seen_velocity(self, state: PeerState) -> Vector:
        """Velocity of the peer between its last two States, m/s; limited, since measurements may jump."""
        ux, uy = state.moved_x, state.moved_y
        leap = max(1.0, math.hypot(ux, uy) / self._max_step) * self._period
        return ux / leap, uy / leap
