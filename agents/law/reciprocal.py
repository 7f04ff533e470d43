"""Reciprocal velocities where they lead on, the paper's flow where they do not.

A robot goes straight to its goal if the reciprocal half-planes of all disks within reach allow it (van den
Berg, Guy, Lin, Manocha, "Reciprocal n-Body Collision Avoidance", 2011). If not, it takes the allowed velocity
nearest to straight on. Where many are about to meet in one place, straight on is first turned to the left, so
that all of them go round it (`roundabout`). Where that gets it too little nearer to its goal, close to the
goal, and while it escapes from a deadlock, it follows the paper's gradient flow; close to the goal it waits
for those who pass rather than be driven aside, if it has an escape. A peer stands where its wish has taken it
since its State; the own velocity is the own last wish, too, so that both ends reckon with the same.
"""

from __future__ import annotations

import math
from typing import Final, final

from agents.law.additions import AugmentedLaw
from agents.law.api import View
from agents.law.half_planes import nearest, reciprocal
from agents.law.roundabout import Encounters, Roundabout, roundabout, together
from agents.lines.line import HalfPlane
from protocol.geometry import Disk
from protocol.messages import Vector
from protocol.scenario.model import Scenario

# No constant has a dimension; a lap is the time in which the largest disk moves by its radius at full speed.
HORIZON: Final = 7.0  # laps, ahead of which a velocity keeps clear of each disk
FORESIGHT: Final = 100.0  # laps, ahead of which it is seen that many will meet
TOGETHER: Final = 3.0  # laps before and after the middle one, within which they do
MANY: Final = 5  # peers, from which on the robot goes round the place
LATE: Final = 0.6  # more room on the circle there per lap by which States are late, up to one: so are lines
NEAR: Final = 4.0  # radii from the goal, within which the flow leads there,
ASIDE: Final = 0.5  # unless by less than this share of its speed: then it is better to wait
SLOW: Final = 0.65  # of the free speed: who gets nearer to the goal by less than that follows the flow;
SLOW_ROUND: Final = 0.5  # by less than that, who goes round a place
PAST: Final = 0.01  # radii past a corner that a tick leads: else who stands beside one by rounding would stay
MARGIN: Final = 0.0125  # of the distance of contact
_APART: Final = 0.999999  # of the distance: a half-plane needs disks that are apart


@final
class ReciprocalLaw:
    """One robot's reciprocal velocity; see `agents.law.api.Law`."""

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
        """See `agents.law.api.Law`."""
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
        """See `agents.law.api.Law`."""
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
        """Whether it is better to stand than to be driven aside, near the goal, by those who pass: as long
        as none of them comes at the robot. Who waits in vain is soon stuck, escapes if it may, and follows
        the flow until that leads on."""
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
