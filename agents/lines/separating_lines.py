"""The constraints of one robot towards robots and obstacles: the kernel's bindings as half-planes.

One tick is: `on_grants`, `locate`, `on_state` for late States, `entries` for the own one; `on_state` for the
States of this tick, then `half_planes` for the velocity. No command is outstanding at these moments.
"""

from __future__ import annotations

import math
from typing import Final

from agents.lines.negotiation import ANSWER_TICKS, Bond, Kernel, MovingDisk, Negotiation, deficit, tangent
from agents.lines.own_set import Cover, CoverGeometry, OwnSet, Polygon
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.bodies.sweep import Sweep
from protocol.geometry import Disk as Circle
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.records import NO, LifeGrants, Listed
from protocol.kernel.robot import HALF, RobotLife
from protocol.line import ROUNDING, HalfPlane, Line
from protocol.messages import Answer, FirstLine, Grants, Proposal, Vector
from protocol.region import EVERYWHERE, Region

SHOWN: Final = 2048  # largest number of obeyed lines in Health
FIRSTS: Final = 64  # largest number of first lines in a Command
_ROOM: Final = 0.25  # clearance to make for a first line, own radii
_NEAR: Final = 4.0  # longest motions in a tick beyond which a shape is replaced by the disk around it


class SeparatingLines:
    """All bindings of one life of one robot, and its region.

    Args:
        speed: highest executed speed, m/s.
        period: of one tick, s.
        reach: longest path from the beginning of a tick to a stop, m; 0 for that of a tick at full speed.
        standoff: room that own lines leave on either side, m, if there is enough.
    """

    def __init__(
        self,
        robot: int,
        radius: float,
        *,
        speed: float,
        period: float,
        reach: float = 0.0,
        standoff: float = 0.0,
    ) -> None:
        self.kernel: Kernel | None = None  # its end of all bindings; None before the first grants
        self.wanted = 0.0  # radius of the disk for which own lines leave room, if that is larger, m
        self.part = NO  # disk that only a smaller own disk keeps clear of, as it is taken up; NO for none
        self._robot, self._radius, self._small = robot, radius, radius
        self._period, self._max_step = period, speed * period
        self._reach = reach if reach > 0.0 else self._max_step
        self._negotiation = Negotiation(self._max_step, period, standoff)
        self._each: list[Bond] = []
        self._lines: dict[int, Bond] = {}  # towards the present life of a peer, by peer
        self._still: list[Bond] = []  # towards static disks
        self._tick = 0
        self._own = OwnSet(0.0, 0.0, math.inf)

    # -- grants of the ledger

    def on_grants(self, grants: Grants, neighbours: Neighbours) -> None:
        """Accept the grants of the ledger, unless newer ones were received."""
        kernel = self.kernel
        if kernel is None:
            cover = Cover(self._own, self._radius)
            kernel = self.kernel = RobotLife(self._robot, grants.life, cover, CoverGeometry())
        if grants.life != kernel.life or grants.version <= kernel.version:
            return
        kernel.receive(_life_grants(grants))
        known, self._each = {bond.end.number: bond for bond in self._each}, []
        for listed in grants.bindings:
            end = kernel.ends[listed.number]
            bond = known.get(listed.number)
            if bond is None:
                bond = Bond(end, self._size(end.peer), neighbours.state(end.peer))
            if listed.first is not None:
                bond.first = None
            self._each.append(bond)
        self._each.sort(key=lambda bond: (bond.peer, bond.end.number))
        self._still = [bond for bond in self._each if bond.end.place is not None]
        self._lines = {bond.peer: bond for bond in self._each if not bond.end.static}

    @property
    def version(self) -> int:
        """Newest version of the ledger that was accepted."""
        return NO if self.kernel is None else self.kernel.version

    @property
    def region(self) -> int:
        """Number of the obeyed region."""
        return NO if self.kernel is None else self.kernel.number

    def firsts(self) -> tuple[FirstLine, ...]:
        """First lines to send to the ledger."""
        return tuple([bond.first for bond in self._each if bond.first is not None][:FIRSTS])

    @property
    def peers(self) -> set[int]:
        """Robots that this one is bound to."""
        return {bond.peer for bond in self._each if bond.peer > 0}

    @property
    def region_disk(self) -> Circle | None:
        """The disk that the own disk must not leave; None if there is no limit, or no region yet."""
        kernel = self.kernel
        if kernel is None or kernel.region is None or kernel.region.is_everywhere:
            return None
        return kernel.region.shape.around

    @property
    def ready(self) -> bool:
        """Whether this robot may move."""
        return self.kernel is not None and self.kernel.region is not None

    # -- the own disk

    def locate(
        self,
        tick: int,
        position: Vector,
        bound: float,
        shape: Polygon | None = None,
        swept: Sweep | None = None,
    ) -> None:
        """Take the own position (m) at the start of `tick`, with `bound`, `shape` and `swept` as of
        `OwnSet`."""
        self._tick = tick
        self._own = OwnSet(*position, bound, shape, swept)
        kernel = self.kernel
        if kernel is None:
            return
        kernel.locate(Cover(self._own, self._radius), Cover(self._own, self._small))
        for bond in self._still:
            self._turn(kernel, bond)
        offered = kernel.offered
        is_new = kernel.offered_number > max(kernel.number, kernel.life)
        if is_new and offered is not None and CoverGeometry().inside(kernel.body, offered):
            kernel.adopt()

    def _turn(self, kernel: Kernel, bond: Bond) -> None:
        """Turn the half-plane towards a static disk, or find the first line towards it."""
        own, end = self._own, bond.end
        if end.place is None or not (bond.is_asked or end.static):
            return
        if end.state == HALF and bond.half_planes[0].slack(own.x, own.y) > own.bound + _NEAR * self._reach:
            return  # far enough away
        near = bond.own_radius + own.bound + _NEAR * self._max_step
        line = tangent(end.place.shape, own.x, own.y, end.low, near)
        if line is None or not kernel.fits(end, line):
            # A set that an obeyed line has cut satisfies no line there with a margin, and may never leave it.
            kept = kernel.kept(end) if bond.is_asked else []
            line = next((each for each in kept if kernel.behind(end, each)), None)
        if line is None:
            return
        if bond.is_asked:
            kernel.freeze(end, line)
            bond.first = FirstLine(end.number, line.nx, line.ny, line.offset)
        else:
            kernel.turn(end, line)
        bond.renew()

    def _size(self, peer: int) -> float:
        """Radius of the disk that a peer constrains, m."""
        return self._small if peer == self.part else self._radius

    def enlarge(self, radius: float, part: int) -> bool:
        """Enlarge the own disk to `radius`, m, if that satisfies all constraints; returns whether it does.

        The disk `part`, which is taken up, constrains only the present size.
        """
        kernel, geometry = self.kernel, CoverGeometry()
        if kernel is None or kernel.region is None:
            return False
        small = self._size(part)
        body, own = Cover(self._own, radius), Cover(self._own, small)
        if not (
            geometry.inside(body, kernel.region)
            and all(geometry.keeps(own if each.peer == part else body, each) for each in kernel.ends.values())
        ):
            return False
        kernel.command(body, own, part)
        self._radius, self._small, self.part = radius, small, part
        self._renew()
        return True

    def resize(self, radius: float) -> None:
        """Reduce the own disk to `radius`, m, or set that of a new life."""
        self._radius = self._small = radius
        self.part = NO
        self._renew()

    def _renew(self) -> None:
        for bond in self._each:
            bond.resize(self._size(bond.peer))

    # -- States of peers

    def on_state(self, state: PeerState) -> None:
        """Process the proposals and answers of a peer's State, which may be old or repeated."""
        bond, kernel = self._lines.get(state.robot), self.kernel
        if bond is None or kernel is None:
            return
        bond.state, lines = state, bond.end.lines
        if isinstance(lines, Owner):
            for answer in state.answers:
                if answer.binding == bond.end.number and lines.seen < answer.seen <= lines.number:
                    lines.on_answer(answer.held, answer.seen)
                    bond.renew()
        elif isinstance(lines, Follower):
            self._on_proposals(kernel, bond, lines, state)

    def _on_proposals(self, kernel: Kernel, bond: Bond, lines: Follower[Line], state: PeerState) -> None:
        for offer in state.proposals:
            if offer.binding != bond.end.number:
                continue
            bond.answers_left = ANSWER_TICKS
            if offer.number > lines.seen:
                line = Line(offer.nx, offer.ny, offer.offset)
                lines.on_proposal(offer.number, line, kernel.fits(bond.end, line))
                bond.renew()

    def entries(self, desired: Vector) -> tuple[tuple[Proposal, ...], tuple[Answer, ...]]:
        """Proposals and answers for this tick's State; `desired`: velocity that the law requests, m/s."""
        kernel = self.kernel
        if kernel is None:
            return (), ()
        standing = not self.ready
        me = self._own_disk((0.0, 0.0) if standing else desired)
        return self._negotiation.entries(self._tick, self._lines.values(), me, kernel, standing=standing)

    def _own_disk(self, velocity: Vector) -> MovingDisk:
        """The own disk, with all further motion of its centre by sent commands."""
        own = self._own
        me = MovingDisk(own.x, own.y, max(self._radius, self.wanted) + own.bound, *velocity)
        if own.swept is None:
            return me
        mx, my = own.swept.middle
        return MovingDisk(me.x + mx, me.y + my, me.radius + own.swept.spread, *velocity)

    # -- constraints

    def make_room(self, desired: Vector) -> Vector:
        """The desired velocity (m/s), directed away from a disk for which there is no first line yet."""
        own, (vx, vy) = self._own, desired
        for bond in self._still:
            place = bond.end.place
            if place is None or not bond.is_asked:
                continue
            room = bond.own_radius + own.bound + _ROOM * bond.own_radius
            dx, dy = deficit(place.shape, own.x, own.y, room)
            length = math.hypot(dx, dy)
            if length > 0.0:
                nx, ny = dx / length, dy / length
                more = max(0.0, length / self._period - nx * vx - ny * vy)
                vx, vy = vx + more * nx, vy + more * ny
        return vx, vy

    def half_planes(self) -> list[HalfPlane]:
        """Where the estimated own centre must stay, as far as it is within reach in a tick; radius and extent
        of the own set are subtracted."""
        own = self._own
        x, y = own.x, own.y
        near = own.bound + 2.0 * ROUNDING + 2.0 * self._reach
        found = []
        for bond in self._each:
            for side in bond.half_planes:
                if side.slack(x, y) < near:
                    found.append(own.kept_in(side.nx, side.ny, side.limit))
        return found

    def crossed(self, x: float, y: float, radius: float) -> list[tuple[int, HalfPlane]]:
        """Obeyed half-planes, by peer, with edges within `radius` (m) of (x, y)."""
        return [
            (bond.peer, side) for bond in self._each for side in bond.half_planes if side.slack(x, y) < radius
        ]

    def obeyed_lines(self) -> tuple[tuple[int, float, float, float], ...]:
        """Obeyed lines towards robots, at most `SHOWN`, for a monitor: peer, nx, ny, limit; the own disk
        keeps n.x <= limit."""
        found = [(bond.peer, side) for bond in self._each if bond.peer > 0 for side in bond.half_planes]
        return tuple((peer, side.nx, side.ny, side.limit + self._radius) for peer, side in found[:SHOWN])


def _life_grants(grants: Grants) -> LifeGrants[Region, Line]:
    """The grants of a Tick, as records of the kernel."""
    region = EVERYWHERE if grants.region is None else Region(Circle(*grants.region))
    listed: list[Listed[Region, Line]] = []
    for each in grants.bindings:
        place = each.place
        listed.append(
            Listed(
                each.number,
                each.peer,
                None if each.first is None else Line(*each.first),
                None if place is None else Region(place),
                each.static,
            )
        )
    return LifeGrants(grants.life, grants.version, grants.number, region, listed)
