"""Reciprocal velocities where there is room, the paper's flow where there is none.

Each robot takes the allowed velocity nearest to straight-to-the-goal, under the reciprocal half-planes of all
peers. Where that gets it too little nearer to its goal, close to the goal, and while it escapes from a
deadlock, it follows the gradient flow instead.
"""

from __future__ import annotations

import math
from typing import final

from agents.laws.gradient import GradientLaw
from agents.laws.velocity_obstacle import reciprocal
from agents.laws.velocity_program import nearest
from agents.laws.view import View
from agents.lines.line import HalfPlane
from agents.peers.state import PeerState
from protocol.scenario.model import Scenario

Vector = tuple[float, float]

HORIZON: float = 10.0  # laps: times in which a disk moves by its radius at full speed
TURN: float = 0.1  # rad, to the left, of the wish of a robot that is in somebody's way
MOST: float = 0.3  # rad
NEAR: float = 2.0  # radii from the goal within which the flow leads there
SLOW: float = 0.5  # of the free speed: who gets nearer to the goal by less than that follows the flow
MARGIN: float = 0.0125  # of the contact distance
LATE: float = 3.0  # times what a robot drives during the age of a State: lines lag by round trips
LATEST: float = 0.5  # of the contact distance: by no more than this


@final
class ReciprocalLaw:
    """One robot's reciprocal velocity; see `agents.laws.law.Law`."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        spec, control = scenario.spec(robot), scenario.control
        self._gradient = GradientLaw(scenario, robot)
        self._radius = spec.radius
        self._room = scenario.workspace.radius - spec.radius
        self._speed, self._period = control.speed, scenario.time.step
        self._lap = max(each.radius for each in scenario.robots) / control.speed
        self._wish: Vector = (0.0, 0.0)

    def velocity(self, view: View) -> Vector:
        """See `agents.laws.law.Law`."""
        self._gradient.look(view)
        strength = self._gradient.stuck(view, self._wish)
        found = self._reciprocal(view) if strength == 0.0 else None
        self._wish = self._gradient.flow(view, strength) if found is None else found
        return self._wish

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """See `agents.laws.law.Law`."""
        return self._gradient.slice_norm(position, goal)

    def _reciprocal(self, view: View) -> Vector | None:
        """The reciprocal velocity, if it leads on."""
        ex, ey = view.goal[0] - view.position[0], view.goal[1] - view.position[1]
        away = math.hypot(ex, ey)
        if away <= NEAR * self._radius:
            return None
        rate = min(self._speed / away, 1.0 / self._period)
        px, py = rate * ex, rate * ey
        limits = self._limits(view)
        barring = _violated(px, py, limits)
        if barring == 0:
            return px, py
        turn = min(TURN * barring, MOST)
        cosine, sine = math.cos(turn), math.sin(turn)
        vx, vy = nearest((cosine * px - sine * py, sine * px + cosine * py), limits, self._speed, 1)[0]
        return (vx, vy) if vx * ex + vy * ey >= SLOW * rate * away * away else None

    def _limits(self, view: View) -> list[HalfPlane]:
        """Of velocities: the boundary first, then peers, the nearest first."""
        x, y = view.position
        reach = 2.0 * self._speed * HORIZON * self._lap
        found: list[tuple[float, int, HalfPlane]] = []
        standing = view.neighbours.standing
        for state in view.neighbours.moving():
            if not state.placed:
                continue
            age = (view.tick - state.tick) * self._period
            rx, ry = state.x + age * state.vx - x, state.y + age * state.vy - y
            contact = self._radius + state.radius
            room = math.hypot(rx, ry) - contact
            if room <= reach:
                late = min(LATE * self._speed * age, LATEST * contact)
                contact *= 1.0 + MARGIN
                found.append((room, state.robot, self._half_plane(rx, ry, contact + late, state)))
        for robot, member in standing.items():
            if member.position is not None:
                rx, ry = member.position[0] - x, member.position[1] - y
                contact = self._radius + member.radius
                room = math.hypot(rx, ry) - contact
                if room <= reach:
                    found.append((room, robot, self._half_plane(rx, ry, contact * (1.0 + MARGIN), None)))
        found.sort(key=_nearness)
        return [self._wall(x, y), *[each[2] for each in found]]

    def _half_plane(self, rx: float, ry: float, contact: float, state: PeerState | None) -> HalfPlane:
        distance = math.hypot(rx, ry)
        if distance <= contact:
            contact = 0.999999 * distance
        vx, vy = self._wish
        horizon = HORIZON * self._lap
        if state is None:
            return reciprocal(rx, ry, contact, vx, vy, 0.0, 0.0, horizon, 1.0)
        return reciprocal(rx, ry, contact, vx, vy, state.vx, state.vy, horizon, 0.5)

    def _wall(self, x: float, y: float) -> HalfPlane:
        distance = math.hypot(x, y)
        if distance == 0.0:
            return HalfPlane(1.0, 0.0, 2.0 * self._speed)
        return HalfPlane(x / distance, y / distance, max(0.0, self._room - distance) / (2.0 * self._period))


def _nearness(found: tuple[float, int, HalfPlane]) -> tuple[float, int]:
    return found[0], found[1]


def _violated(vx: float, vy: float, limits: list[HalfPlane]) -> int:
    count = 0
    for each in limits:
        if each.nx * vx + each.ny * vy > each.limit:
            count += 1
    return count
