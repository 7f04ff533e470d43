"""Reciprocal velocities where they lead on, the paper's flow where they do not.

A robot takes the velocity nearest to straight on that the reciprocal half-planes of all disks within reach
allow (van den Berg, Guy, Lin, Manocha, "Reciprocal n-Body Collision Avoidance", 2011, section 4), or the one
that violates them least (section 5). Where many are about to meet in one place, straight on is first turned
to the left, so that all of them go round it (`roundabout`). Where that leads too little towards its goal,
close to the goal, and while it escapes from a deadlock, it follows the paper's gradient flow; close to the
goal it waits for passing peers rather than be driven aside, if it has an escape. A peer is where its wish has
taken it since its State; the own velocity is the own last wish, too, so that both ends reckon with the same.

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
from protocol.geometry import Disk
from protocol.line import HalfPlane
from protocol.messages import Vector
from protocol.scenario.model import Scenario

# No constant has a dimension; a lap is the time in which the largest disk moves by its radius at full speed.
HORIZON: Final = 7.0  # laps, ahead of which a velocity keeps clear of each disk
FORESIGHT: Final = 100.0  # laps, ahead of which it is seen that many will meet
TOGETHER: Final = 3.0  # laps before and after the middle one, within which they do
MANY: Final = 5  # peers, from which on the robot goes round the place
LATE: Final = 0.6  # more room on the circle there per lap by which States are late, up to one: so are lines
NEAR: Final = 4.0  # radii from the goal, within which the flow leads there
ASIDE: Final = 0.5  # of its speed: below this share of it, towards the goal, waiting is better
SLOW: Final = 0.65  # of the free speed: below it, towards the goal, the flow is followed
SLOW_ROUND: Final = 0.5  # the same on the way around a place
PAST: Final = 0.01  # radii past a corner that a tick leads, so that no robot stays at one by rounding
MARGIN: Final = 0.0125  # of the distance of contact
_APART: Final = 0.999999  # of the distance: a half-plane needs disks that are apart
_PARALLEL: Final = 1e-12
_ROUNDING: Final = 1e-12  # of the speed limit: a violation by less is none


def reciprocal(
    rx: float,
    ry: float,
    contact: float,
    vx: float,
    vy: float,
    ux: float,
    uy: float,
    horizon: float,
    share: float,
) -> HalfPlane:
    """Own velocities n.v <= limit.

    Args:
        rx, ry: from the own centre to the other's, m, farther than `contact` apart.
        contact: distance at which they touch, m.
        vx, vy: own velocity that both reckon with, m/s.
        ux, uy: the other's, m/s.
        horizon: s.
        share: of the change of relative velocity that this robot takes upon itself.
    """
    dx, dy = vx - ux, vy - uy
    square = rx * rx + ry * ry
    wx, wy = dx - rx / horizon, dy - ry / horizon  # from the centre of the obstacle's round end
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
    """The velocity, m/s.

    Args:
        wish: m/s.
        limits: of velocities, m/s.
        speed: the largest, m/s.
        hard: the first so many half-planes leave room together, and are kept where all are too many.
    """
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
    """The velocity that violates the worst of all but the hard half-planes least, from `begin` on."""
    x, y = velocity
    worst = 0.0
    for index in range(max(begin, hard), len(limits)):
        edge = limits[index]
        if edge.nx * x + edge.ny * y - edge.limit <= worst:
            continue
        # Where this half-plane is violated more than every earlier one: as far to its inside as they allow.
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
    direction; and whether there is any."""
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
    """One robot's reciprocal velocity: a `Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control = scenario.spec(robot), scenario.control
        self._gradient = AugmentedLaw(scenario, robot)
        self._escapes = "escape" in control.additions  # without it no wait in vain would end
        self._radius = spec.radius
        room = scenario.workspace.shape
        self._rim = room.radius - spec.radius if isinstance(room, Disk) else 0.0
        self._speed, self._period = control.speed, scenario.time.step
        self._lap = max(each.radius for each in scenario.robots) / control.speed
        self._late = 0.0  # laps, the age of the oldest State of a disk within reach
        ahead = FORESIGHT * self._lap
        self._encounters = Encounters(robot, spec.radius, scenario.time.step, ahead)
        self._roundabout: Roundabout | None = None  # as first seen, until it is passed
        self._wanted: Vector = (0.0, 0.0)  # last, without an escape
        self._wish: Vector = (0.0, 0.0)
        self._patient = True  # not since an escape, until something leads on again

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
        """The reciprocal velocity, if it leads on."""
        (x, y), (gx, gy) = view.position, self._gradient.aim
        ex, ey = gx - x, gy - y
        away = math.hypot(ex, ey)
        if away <= NEAR * self._radius:
            return None
        rate = min(self._speed / away, 1.0 / self._period)
        ahead = max(self._gradient.straight, PAST * self._radius)
        rate = min(rate, ahead / (self._period * away))
        px, py = rate * ex, rate * ey
        limits = self._walls(x, y)
        walls = len(limits)
        limits += self._obstacles(view)
        turn = self._turn(view, (px, py))
        if turn == 0.0 and _violated(px, py, limits) == 0:
            return px, py
        cosine, sine = math.cos(turn), math.sin(turn)
        wish = cosine * px - sine * py, sine * px + cosine * py
        vx, vy = nearest(wish, limits, self._speed, walls)
        slow = SLOW_ROUND if turn > 0.0 else SLOW
        return (vx, vy) if vx * ex + vy * ey >= slow * rate * away * away else None

    def _waits(self, view: View, flow: Vector) -> bool:
        """Whether to stand near the goal rather than be driven aside by peers that pass: as long as none of
        them comes at the robot. If it waits in vain, it soon escapes, and follows the flow until that leads
        on."""
        (x, y), (gx, gy) = view.position, self._gradient.aim
        ex, ey = gx - x, gy - y
        away = math.hypot(ex, ey)
        if flow[0] * ex + flow[1] * ey >= ASIDE * away * math.hypot(*flow):
            self._patient = True
            return False
        if not (self._escapes and self._patient) or away > NEAR * self._radius:
            return False
        return _violated(0.0, 0.0, self._obstacles(view)) == 0

    def _turn(self, view: View, way: Vector) -> float:
        """By how much the straight way (m/s) is to be turned to the left, rad."""
        place = self._roundabout
        if place is None or not place.is_ahead(view.position, way):
            met = together(self._encounters.met(view, way), TOGETHER * self._lap)
            place = roundabout(view.position, way, met) if len(met) >= MANY else None
            self._roundabout = place
        if place is None:
            return 0.0
        return place.turn(view.position, way, room=1.0 + LATE * min(self._late, 1.0))

    def _walls(self, x: float, y: float) -> list[HalfPlane]:
        """Of velocities that come near what is straight, or the boundary: half the way to it in a tick."""
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
        """Of velocities, one for every disk within reach, the nearest first."""
        x, y = view.position
        self._late = 0.0
        found: list[tuple[float, HalfPlane]] = []
        for state in view.neighbours.moving():
            if state.placed:
                age = (view.tick - state.tick) * self._period
                rx, ry = state.x + age * state.vx - x, state.y + age * state.vy - y
                if self._add(found, rx, ry, state.radius, state.vx, state.vy, 0.5):
                    self._late = max(self._late, age / self._lap)
        for member in view.neighbours.standing.values():
            if member.position is not None:
                rx, ry = member.position[0] - x, member.position[1] - y
                self._add(found, rx, ry, member.radius, 0.0, 0.0, 1.0)
        for disk in self._gradient.obstacles:
            if disk.radius > 0.0:
                self._add(found, disk.x - x, disk.y - y, disk.radius, 0.0, 0.0, 1.0)
        found.sort(key=_nearness)
        return [each[1] for each in found]

    def _add(
        self,
        found: list[tuple[float, HalfPlane]],
        rx: float,
        ry: float,
        radius: float,
        ux: float,
        uy: float,
        share: float,
    ) -> bool:
        """Take up the half-plane for a disk at (rx, ry) from the own centre if it can be met in the horizon;
        whether it can."""
        contact, distance = self._radius + radius, math.hypot(rx, ry)
        room, horizon = distance - contact, HORIZON * self._lap
        if distance == 0.0 or room > 2.0 * self._speed * horizon:
            return False
        contact = min((1.0 + MARGIN) * contact, _APART * distance)
        vx, vy = self._wish
        found.append((room, reciprocal(rx, ry, contact, vx, vy, ux, uy, horizon, share)))
        return True


def _nearness(found: tuple[float, HalfPlane]) -> float:
    return found[0]


def _violated(vx: float, vy: float, limits: list[HalfPlane]) -> int:
    count = 0
    for each in limits:
        if each.nx * vx + each.ny * vy > each.limit:
            count += 1
    return count
