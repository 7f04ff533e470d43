"""A base with two wheels, integrated in small steps.

They follow what they are told with a lag, within their acceleration, and slip; a base that hears nothing for
its timeout brakes.
"""

import math
import random

from agents.bases.ros_messages import NANO, Odometry, Pose, StampedPose, Velocity, decode, header_at
from protocol.scenario.model import Scenario

STEP = 0.005  # s, of the wheels
SERVO = 0.010  # s, by which wheels lag
EPOCH = 1_700_000_000 * NANO  # of the bases' clocks: no other process uses them
Vector = tuple[float, float]


def turn(angle: float) -> list[float]:
    return [0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)]


class Wheels:
    """One base on the floor: axle's middle, direction, and the speeds of two wheels."""

    def __init__(self, scenario: Scenario, robot: int, rng: random.Random) -> None:
        spec, self.body, self.table = scenario.spec(robot), scenario.body_of(robot), scenario.base_of(robot)
        self.sensing = scenario.sensing_of(robot)
        self.rng = rng
        self.yaw = spec.heading
        self.x = spec.start[0] - self.body.offset * math.cos(self.yaw)
        self.y = spec.start[1] - self.body.offset * math.sin(self.yaw)
        self.left = self.right = 0.0
        self.aims: Vector = (0.0, 0.0)  # of the wheels
        self.heard = -math.inf
        self.scale = 1.0 + rng.uniform(-0.8, 0.8) * self.body.odometry  # of odometry's lengths
        self.ox, self.oy, self.oyaw = rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-3, 3)
        self.dead = False

    @property
    def control(self) -> Vector:
        """Where the control point is, m."""
        lead = self.body.offset
        return self.x + lead * math.cos(self.yaw), self.y + lead * math.sin(self.yaw)

    def on_message(self, payload: bytes, now: float) -> None:
        velocity = decode(Velocity, payload)
        across = 0.5 * velocity.angular[2] * self.body.track
        self.aims, self.heard = (velocity.linear[0] - across, velocity.linear[0] + across), now

    def roll(self, now: float) -> None:
        """Go on for a step."""
        if self.dead:
            return
        if now - self.heard > self.table.timeout:
            self.aims = (0.0, 0.0)
        most = self.body.acceleration * STEP
        for name, aim in zip(("left", "right"), self.aims, strict=True):
            speed = getattr(self, name)
            wanted = (aim - speed) * (1.0 - math.exp(-STEP / SERVO))
            setattr(self, name, speed + max(-most, min(most, wanted)))
        ahead, rate = 0.5 * (self.left + self.right), (self.right - self.left) / self.body.track
        middle = self.yaw + 0.5 * rate * STEP
        dx, dy = ahead * STEP * math.cos(middle), ahead * STEP * math.sin(middle)
        self.x, self.y, self.yaw = self.x + dx, self.y + dy, self.yaw + rate * STEP
        askew = self.oyaw - self.yaw + rate * STEP
        self.ox += self.scale * (dx * math.cos(askew) - dy * math.sin(askew))
        self.oy += self.scale * (dx * math.sin(askew) + dy * math.cos(askew))
        self.oyaw += rate * STEP

    def odometry(self, now: float) -> Odometry:
        ahead, rate = 0.5 * (self.left + self.right), (self.right - self.left) / self.body.track
        return Odometry(
            header_at(EPOCH + round(now * NANO), "odom"),
            "base_link",
            Pose([self.ox, self.oy, 0.0], turn(self.oyaw)),
            [0.0] * 36,
            Velocity([ahead, 0.0, 0.0], [0.0, 0.0, rate]),
            [0.0] * 36,
        )

    def pose(self, now: float) -> StampedPose:
        size, angle = self.sensing.bound * math.sqrt(self.rng.random()), self.rng.uniform(0.0, math.tau)
        askew = self.rng.uniform(-0.9, 0.9) * self.sensing.heading
        place = [self.x + size * math.cos(angle), self.y + size * math.sin(angle), 0.0]
        return StampedPose(header_at(EPOCH + round(now * NANO), "map"), Pose(place, turn(self.yaw + askew)))
