"""A base outside: which messages it hears and says, and how late everything may be."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal

from annotated_types import Len

from protocol.scenario.body import Body
from protocol.scenario.ranges import STRICT, NonNegative, Positive

_Topic = Annotated[str, Len(1, 200)]


@dataclass(frozen=True, slots=True)
class Base:
    """What moves a robot of a fleet that is not simulated, and tells it where it is.

    ros2: by ROS 2 messages over zenoh, under the keys of zenoh-bridge-ros2dds, `<namespace>/<topic>`: a Twist
    or TwistStamped to the base; Odometry from it, and a PoseStamped from a localisation.
    """

    __pydantic_config__ = STRICT
    kind: Literal["ros2"] = "ros2"
    namespace: _Topic = "/bot{id}"  # {id} stands for the robot's id
    velocity: _Topic = "cmd_vel"
    stamped: bool = False  # whether velocities are TwistStamped, else Twist
    odometry: _Topic = "odom"
    pose: _Topic = "pose"
    map_frame: str = "map"  # of poses; the workspace is described in it
    odometry_frame: str = "odom"
    base_frame: str = "base_link"  # what odometry and poses are of: the axle's middle
    timeout: Positive = 0.25  # s without a velocity, after which the base begins to brake by itself
    patience: NonNegative = 0.1  # s without a tick, after the one it is in, until the robot has it brake
    latency: NonNegative = 0.03  # s that a message between robot and base may take, one way
    age: Positive = 0.1  # s since the odometry arrived with which a tick may begin

    def carries(self, body: Body) -> Body:
        """The body as the filter has to take it: with all that comes late."""
        hold = self.timeout + self.latency + self.patience
        return replace(body, hold=hold, lag=body.lag + self.age + 2.0 * self.latency)

    def key(self, robot: int, topic: str) -> str:
        """The key of a topic."""
        return f"{self.namespace.replace('{id}', str(robot)).strip('/')}/{topic.strip('/')}"
