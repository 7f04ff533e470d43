"""Reciprocal velocities, and the paper's flow where these make no progress.

A robot takes the velocity nearest to straight on that the reciprocal half-planes of all disks within reach
allow (van den Berg, Guy, Lin, Manocha, "Reciprocal n-Body Collision Avoidance", 2011, section 4), or the one
that violates them least (section 5). Where many are about to meet, the straight direction is first rotated to
the left, so that all of them go round the place (`roundabout`). Where that makes too little progress, close
to the goal, and during an escape from a deadlock, it follows the paper's gradient flow; close to the goal it
rather waits for passing peers than is driven aside, if it has the escape. Peers are extrapolated by the wish
of their States; the own velocity is the last own wish, too, so that both ends use the same values.

The linear programs are solved one constraint after another (Seidel; de Berg et al., "Computational Geometry",
chapter 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from agents.law.additions import AugmentedLaw
from agents.law.api import View
from agents.law.roundabout import Encounters, Roundabout, roundabout, together
from agents.peers.state import PeerState
from protocol.geometry import Disk
from protocol.line import HalfPlane
from protocol.messages import Vector
from protocol.scenario.model import Scenario

# Dimensionless. A lap is the time in which the largest disk moves by its radius at full speed.
HORIZON: Final = 7.0  # laps, time for which a velocity avoids each disk
FORESIGHT: Final = 100.0  # laps, time ahead in which encounters are predicted
TOGETHER: Final = 3.0  # laps around their median in which encounters are simultaneous
MANY: Final = 5  # simultaneous encounters from which the robot goes round the place
LATE: Final = 0.6  # additional room on the circle per lap of latency, up to one lap
NEAR: Final = 4.0  # radii from the goal within which the flow is followed
ASIDE: Final = 0.5  # share of the flow's speed towards the goal below which waiting is better
SLOW: Final = 0.65  # share of the free speed towards the goal below which the flow is followed
SLOW_ROUND: Final = 0.5  # the same in a roundabout
PAST: Final = 0.01  # radii past a corner in a tick, so that rounding holds no robot there
MARGIN: Final = 0.0125  # addition to the contact distance, relative
_APART: Final = 0.999999  # largest contact distance over distance: a half-plane needs disjoint disks
_PARALLEL: Final = 1e-12
_ROUNDING: Final = 1e-12  # ignored violation, speed limits


def reciprocal(
    to: Vector, contact: float, own: Vector, other: Vector, horizon: float, share: float
) -> HalfPlane:
    """Half-plane n.v <= limit of own velocities.

    Args:
        to: from the own centre to the other's, m, longer than `contact`.
        contact: contact distance, m.
        own, other: velocities that both ends assume, m/s.
        horizon: s.
        share: this robot's share of the change of relative velocity.
    """
    (rx, ry), (vx, vy) = to, own
    dx, dy = vx - other[0], vy - other[1]
    square = rx * rx + ry * ry
    wx, wy = dx - rx / horizon, dy - ry / horizon  # from the centre of the cone's round end
    size = math.hypot(wx, wy)
    ahead = wx * rx + wy * ry
    if ahead < 0.0 and -ahead > contact * size:
        nx, ny = -wx / size, -wy / size
        depth = contact / horizon - size
    else:
        leg = math.sqrt(max(0.0, square - contact * contact))
        turn = leg if rx * wy - ry * wx > 0.0 else -leg
        nx, ny = (rx * contact + ry * turn) / square, (ry * contact - rx * turn) / square
        depth = nx * dx + ny * dy
    return HalfPlane(nx, ny, nx * vx + ny * vy - share * depth)


def nearest(wish: Vector, limits: Sequence[HalfPlane], speed: float, hard: int = 0) -> Vector:
    """The velocity nearest to `wish` within `limits` and `speed`, m/s. The first `hard` half-planes leave
    room together, and are kept where all are too many."""
    x, y = wish
    length = math.hypot(x, y)
    if length > speed:
        x, y = x * speed / length, y * speed / length
    for index, edge in enumerate(limits):
        if edge.nx * x + edge.ny * y > edge.limit + _ROUNDING * speed:
            found, x_new, y_new = _on_edge(limits, index, speed, wish[0], wish[1], False)
            if not found:
                return _least(limits, index, (x, y), speed, hard)
            x, y = x_new, y_new
    return x, y


def _least(limits: Sequence[HalfPlane], begin: int, velocity: Vector, speed: float, hard: int) -> Vector:
    """The velocity within the hard limits that violates those from `begin` on least."""
    x, y = velocity
    worst = 0.0
    for index in range(max(begin, hard), len(limits)):
        edge = limits[index]
        if edge.nx * x + edge.ny * y - edge.limit <= worst:
            continue
        # Move as far inside this half-plane as possible while it is the most violated one.
        others = list(limits[:hard])
        for other in limits[hard:index]:
            nx, ny = other.nx - edge.nx, other.ny - edge.ny
            size = math.hypot(nx, ny)
            if size > _PARALLEL:
                others.append(HalfPlane(nx / size, ny / size, (other.limit - edge.limit) / size))
        found, x_new, y_new = _farthest(others, -edge.nx, -edge.ny, speed)
        if found:
            x, y = x_new, y_new
        worst = edge.nx * x + edge.ny * y - edge.limit
    return x, y


def _farthest(limits: Sequence[HalfPlane], dx: float, dy: float, speed: float) -> tuple[bool, float, float]:
    """The velocity farthest in the unit direction (dx, dy), if there is any."""
    x, y = dx * speed, dy * speed
    for index, edge in enumerate(limits):
        if edge.nx * x + edge.ny * y > edge.limit + _ROUNDING * speed:
            found, x, y = _on_edge(limits, index, speed, dx, dy, True)
            if not found:
                return False, 0.0, 0.0
    return True, x, y


def _on_edge(
    limits: Sequence[HalfPlane], index: int, speed: float, wx: float, wy: float, far: bool
) -> tuple[bool, float, float]:
    """The point on the edge of one half-plane, within all earlier ones, nearest to (wx, wy), or `far` in that
    direction; and whether there is one.
    """
    edge = limits[index]
    nx, ny, limit = edge.nx, edge.ny, edge.limit
    square = speed * speed - limit * limit
    if square < 0.0:
        return False, 0.0, 0.0
    high = math.sqrt(square)
    low = -high
    for other in limits[:index]:
        along = nx * other.ny - ny * other.nx  # m . t with the edge's direction t = (-ny, nx)
        room = other.limit - limit * (other.nx * nx + other.ny * ny)
        if along > _PARALLEL:
            high = min(high, room / along)
        elif along < -_PARALLEL:
            low = max(low, room / along)
        elif room < -_ROUNDING * speed:
            return False, 0.0, 0.0
    if low > high:
        return False, 0.0, 0.0
    along = nx * wy - ny * wx
    if far:
        along = high if along > 0.0 else low
    along = min(max(along, low), high)
    return True, limit * nx - along * ny, limit * ny + along * nx


@final
class ReciprocalLaw:
    """Reciprocal velocity of one robot: a `Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control = scenario.spec(robot), scenario.control
        self._gradient = AugmentedLaw(scenario, robot)
        self._escapes = "escape" in control.additions  # without it a vain wait would not end
        self._radius = spec.radius
        room = scenario.workspace.shape
        self._rim = room.radius - spec.radius if isinstance(room, Disk) else 0.0
        self._speed, self._period = control.speed, scenario.time.step
        self._lap = max(each.radius for each in scenario.robots) / control.speed
        self._late = 0.0  # laps, age of the oldest State of a disk within reach
        ahead = FORESIGHT * self._lap
        self._encounters = Encounters(robot, spec.radius, scenario.time.step, ahead)
        self._roundabout: Roundabout | None = None  # kept until the robot has passed it
        self._wanted: Vector = (0.0, 0.0)  # last velocity, without an escape
        self._wish: Vector = (0.0, 0.0)
        self._patient = True  # False from an escape to the next progress

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s."""
        gradient = self._gradient
        gradient.look(view)
        strength = gradient.stuck(view, self._wanted)
        found = self._reciprocal(view) if strength == 0.0 else None
        if found is not None:
            self._patient = True
            self._wanted = self._wish = found
            return found
        self._wanted = gradient.flow(view, 0.0)
        if strength > 0.0:
            self._patient = False
            self._wish = gradient.flow(view, strength)
        else:
            if self._waits(view, self._wanted):
                self._wanted = (0.0, 0.0)
            self._wish = self._wanted
        return self._wish

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i|, m, of the gradient law."""
        return self._gradient.slice_norm(position, goal)

    def _reciprocal(self, view: View) -> Vector | None:
        """The reciprocal velocity, if it makes enough progress."""
        (x, y), (gx, gy) = view.position, self._gradient.aim
        ex, ey = gx - x, gy - y
        distance = math.hypot(ex, ey)
        if distance <= NEAR * self._radius:
            return None
        rate = min(self._speed / distance, 1.0 / self._period)
        ahead = max(self._gradient.straight, PAST * self._radius)
        rate = min(rate, ahead / (self._period * distance))
        px, py = rate * ex, rate * ey
        limits = self._walls(x, y)
        walls = len(limits)
        limits += self._obstacles(view)
        turn = self._turn(view, (px, py))
        if turn == 0.0 and _is_allowed(px, py, limits):
            return px, py
        cosine, sine = math.cos(turn), math.sin(turn)
        wish = cosine * px - sine * py, sine * px + cosine * py
        vx, vy = nearest(wish, limits, self._speed, walls)
        slow = SLOW_ROUND if turn > 0.0 else SLOW
        return (vx, vy) if vx * ex + vy * ey >= slow * rate * distance * distance else None

    def _waits(self, view: View, flow: Vector) -> bool:
        """Whether to stand near the goal rather than be driven aside by passing peers, if none of them
        approaches. After a vain wait the robot escapes, and follows the flow until that makes progress.
        """
        (x, y), (gx, gy) = view.position, self._gradient.aim
        ex, ey = gx - x, gy - y
        distance = math.hypot(ex, ey)
        if flow[0] * ex + flow[1] * ey >= ASIDE * distance * math.hypot(*flow):
            self._patient = True
            return False
        if not (self._escapes and self._patient) or distance > NEAR * self._radius:
            return False
        return _is_allowed(0.0, 0.0, self._obstacles(view))

    def _turn(self, view: View, way: Vector) -> float:
        """Angle by which the straight direction (m/s) is rotated to the left, rad."""
        place = self._roundabout
        if place is None or not place.is_ahead(view.position, way):
            met = together(self._encounters.met(view, way), TOGETHER * self._lap)
            place = roundabout(view.position, way, met) if len(met) >= MANY else None
            self._roundabout = place
        if place is None:
            return 0.0
        return place.turn(view.position, way, room=1.0 + LATE * min(self._late, 1.0))

    def _walls(self, x: float, y: float) -> list[HalfPlane]:
        """Limits of velocities towards straight obstacles and the boundary: half the distance in a tick."""
        limits: list[HalfPlane] = []
        if self._rim > 0.0:
            distance = math.hypot(x, y)
            if distance > 0.0:
                limits.append(self._wall(x / distance, y / distance, self._rim - distance))
        for point in self._gradient.obstacles:
            rx, ry = point.x - x, point.y - y
            distance = math.hypot(rx, ry)
            if point.radius == 0.0 and distance > 0.0:
                limits.append(self._wall(rx / distance, ry / distance, distance - self._radius))
        return limits

    def _wall(self, nx: float, ny: float, room: float) -> HalfPlane:
        return HalfPlane(nx, ny, max(0.0, room) / (2.0 * self._period))

    def _obstacles(self, view: View) -> list[HalfPlane]:
        """Limits of velocities, one for every disk within reach, the nearest first."""
        x, y = view.position
        self._late = 0.0
        found: list[tuple[float, HalfPlane]] = []
        for disk in (*self._gradient.disks, *self._gradient.obstacles):
            if isinstance(disk, PeerState):
                age = (view.tick - disk.tick) * self._period
                rx, ry = disk.x + age * disk.vx - x, disk.y + age * disk.vy - y
                if self._add(found, (rx, ry), disk.radius, disk.desired, 0.5):
                    self._late = max(self._late, age / self._lap)
            elif disk.radius > 0.0:
                self._add(found, (disk.x - x, disk.y - y), disk.radius, (0.0, 0.0), 1.0)
        found.sort(key=lambda each: each[0])
        return [each[1] for each in found]

    def _add(
        self, found: list[tuple[float, HalfPlane]], to: Vector, radius: float, other: Vector, share: float
    ) -> bool:
        """Add the half-plane of a disk at `to`, m, from the own centre; False if it is out of reach."""
        contact, distance = self._radius + radius, math.hypot(*to)
        room, horizon = distance - contact, HORIZON * self._lap
        if distance == 0.0 or room > 2.0 * self._speed * horizon:
            return False
        contact = min((1.0 + MARGIN) * contact, _APART * distance)
        found.append((room, reciprocal(to, contact, self._wish, other, horizon, share)))
        return True


def _is_allowed(vx: float, vy: float, limits: list[HalfPlane]) -> bool:
    return all(each.nx * vx + each.ny * vy <= each.limit for each in limits)
