"""A base outside: which messages it hears and says, and how late everything may be."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

from msgspec import Meta

from protocol.errors import UsageError
from protocol.scenario.body import Body, NonNegative, Positive

TOPICS = ("velocity", "odometry", "pose")
FRAMES = ("map_frame", "odometry_frame", "base_frame")
_CHARACTER = r"(?:[A-Za-z0-9_.-]|\{id\})"
_NAME = re.compile(rf"/?(?:{_CHARACTER}+(?:/{_CHARACTER}+)*/?)?")
_Text = Annotated[str, Meta(max_length=200, description="of at most 200 characters")]


@dataclass(frozen=True, slots=True)
class Base:
    """What moves a robot of a fleet that is not simulated, and tells it where it is.

    ros2: by ROS 2 messages over zenoh, under the keys of zenoh-bridge-ros2dds, `<namespace>/<topic>`: a Twist
    or TwistStamped to the base; Odometry from it, and a PoseStamped from a localisation. In every text,
    `{id}` stands for the robot's id.
    """

    kind: Literal["ros2"] = "ros2"
    namespace: _Text = "/bot{id}"  # "/" for a robot that has none
    velocity: _Text = "cmd_vel"
    stamped: bool = False  # whether velocities are TwistStamped, else Twist
    odometry: _Text = "odom"
    pose: _Text = "pose"
    map_frame: _Text = "map"  # of poses; the workspace is described in it
    odometry_frame: _Text = "odom"
    base_frame: _Text = "base_link"  # what odometry and poses are of: the axle's middle
    timeout: Positive = 0.25  # s without a velocity, after which the base begins to brake by itself
    patience: NonNegative = 0.1  # s without a tick, after the one it is in, until the robot has it brake
    latency: NonNegative = 0.03  # s that a message between robot and base may take, one way
    age: Positive = 0.1  # s since the odometry arrived with which a tick may begin

    def carries(self, body: Body) -> Body:
        """The body as the filter has to take it: with all that comes late."""
        hold = self.timeout + self.latency + self.patience
        return replace(body, hold=hold, lag=body.lag + self.age + 2.0 * self.latency)

    def of(self, robot: int) -> Base:
        """The base of one robot: its id in place of `{id}`."""
        names = ("namespace", *TOPICS, *FRAMES)
        named: dict[str, Any] = {name: getattr(self, name).replace("{id}", str(robot)) for name in names}
        return replace(self, **named)

    def key(self, topic: str) -> str:
        """The key of a topic."""
        return f"{self.namespace.strip('/')}/{topic.strip('/')}".lstrip("/")


def ros_name(text: str) -> str:
    """Return `text` if it may be a namespace, or with something between its slashes a topic.

    Raises:
        UsageError: it may not.
    """
    if not _NAME.fullmatch(text):
        raise UsageError(
            f"{text!r} is no ROS name: letters, digits, '_', '-' and '.', with one '/' between words, "
            "and {id} for the robot's id"
        )
    return text
