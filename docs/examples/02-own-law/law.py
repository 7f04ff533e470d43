"""A control law: straight to the goal, and to the right of near disks."""

import math

from agents.law import Law, View
from protocol.scenario.model import Scenario


class KeepRight(Law):
    """Repelled by disks nearer than the robot's radius, and turned to the right of them."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        self.radius = scenario.spec(robot).radius
        self.speed = scenario.control.speed

    def velocity(self, view: View) -> tuple[float, float]:
        """Velocity in m/s; the filter makes it safe."""
        (x, y), (gx, gy) = view.position, view.goal
        distance_to_goal = math.hypot(gx - x, gy - y)
        rate = min(2.0, self.speed / max(distance_to_goal, 1e-9))  # 1/s
        vx, vy = rate * (gx - x), rate * (gy - y)
        for disk in view.neighbours.disks():
            dx, dy = x - disk.x, y - disk.y
            distance = math.hypot(dx, dy)
            push = max(0.0, 1.0 - (distance - self.radius - disk.radius) / self.radius)
            push *= rate * distance_to_goal / distance
            vx, vy = vx + push * (dx + dy), vy + push * (dy - dx)
        scale = min(1.0, self.speed / max(math.hypot(vx, vy), 1e-9))
        return scale * vx, scale * vy
