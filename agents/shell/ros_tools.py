"""A robot's topics for tools of ROS 2, such as RViz: its pose, markers, a stop and a goal."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Final

import msgspec

from agents.bases import dialects as ros
from agents.bases.dialects import Topic
from agents.bases.ros_messages import (
    Flag,
    Header,
    Marker,
    Markers,
    Odometry,
    Pose,
    StampedPose,
    Transform,
    Transforms,
    Velocity,
    decode,
    header_at,
)
from agents.robot import Robot
from agents.shell.ros_link import RosLink
from protocol.bodies.kinematics import turned
from protocol.bus.bus import Bus, RawSample
from protocol.errors import MessageError
from protocol.messages import LARGEST, Command, Line, Vector
from protocol.operations import Outcome, decode_reply
from protocol.scenario.body import Base

PERIOD: Final = 0.1  # s, least time between two transforms
_DRAWN: Final = 5  # transforms for each drawing
_SPHERE, _CYLINDER, _LINES = 2, 3, 5
_HEIGHT, _WIDTH = 0.05, 0.005  # m, of drawings
_NEAR: Final = 6.0  # radii, drawn distance of a line
_LIFETIME: Final = 2  # s, lifetime of drawings


class RosTools:
    """The topics of one robot for tools, on the bus.

    The frame `<namespace>/disk` is its disk's; its only parent is the map. `operations` is the key under
    which the world takes operations.
    """

    def __init__(
        self, base: Base, robot: int, link: RosLink, bus: Bus, operations: str, warn: Callable[[str], None]
    ) -> None:
        self.stopped = False  # a message stopped the robot, and none has released it
        self._base, self._robot = base, robot
        self._bus, self._operations, self._warn = bus, operations, warn
        self._frame = f"{base.namespace.strip('/')}/disk".lstrip("/")
        self._stop = Topic(base.topic("disknav/stop"), ros.BOOL)
        link.subscribe(self._stop, Topic(base.topic("goal_pose"), ros.STAMPED_POSE))
        self._publish_tf = link.publisher(Topic(base.topic("/tf"), ros.TF))
        self._publish_odometry = link.publisher(Topic(base.topic("disknav/odom"), ros.ODOMETRY))
        self._publish_markers = link.publisher(Topic(base.topic("disknav/markers"), ros.MARKERS))
        self._due, self._published = -math.inf, 0

    def on_message(self, topic: Topic, payload: bytes) -> None:
        """Receive a message; raises MessageError, also for a goal in another frame than the map."""
        if topic == self._stop:
            before, self.stopped = self.stopped, decode(Flag, payload).data
            if self.stopped != before:
                self._warn(f"{topic.name} says {'stop; stands' if self.stopped else 'go'}")
            return
        message = decode(StampedPose, payload)
        x, y, _ = message.pose.position
        if message.header.frame != self._base.map_frame:
            text = f"a goal in {message.header.frame!r}, not in {self._base.map_frame!r}"
            raise MessageError("range", text)
        if not math.hypot(x, y) <= LARGEST:
            raise MessageError("range", "a goal that is no number")
        request = {"goal": {"robot": self._robot, "points": [[x, y]]}}
        self._bus.post(self._operations, msgspec.msgpack.encode(request))

    def is_reply(self, event: RawSample) -> bool:
        """Whether an event is the world's reply to an operation; reports a refusal to the operator."""
        if event.key != self._operations:
            return False
        outcome = decode_reply(event.payload, Outcome)
        if not outcome.accepted:
            self._warn(f"a goal is refused: {outcome.text}")
        return True

    def publish(self, core: Robot, command: Command, heading: float) -> None:
        """Publish the payloads that are due, after a Command of a robot with `heading`, rad."""
        now, (position, bound) = time.monotonic(), core.place
        if position is None or now < self._due:
            return
        self._due = now + PERIOD
        header, half = header_at(time.time_ns(), self._base.map_frame), 0.5 * heading
        pose = Pose([*position, 0.0], [0.0, 0.0, math.sin(half), math.cos(half)])
        moved = Transform(header, self._frame, pose.position, pose.orientation)
        self._publish_tf(Transforms([moved]).serialize())
        velocity = turned(*command.velocity, -heading)
        self._publish_odometry(_located(header, self._frame, pose, bound, velocity).serialize())
        if self._published % _DRAWN == 0:
            self._publish_markers(Markers(_drawn(header, pose, core)).serialize())
        self._published += 1


def _located(header: Header, frame: str, pose: Pose, bound: float, velocity: Vector) -> Odometry:
    """The pose; the squared bound is an upper bound of the variance."""
    spread = [0.0] * 36
    spread[0] = spread[7] = bound * bound
    return Odometry(header, frame, pose, spread, Velocity([*velocity, 0.0], [0.0] * 3), [0.0] * 36)


def _drawn(header: Header, pose: Pose, core: Robot) -> list[Marker]:
    goal = Pose([*core.goal, 0.0], [0.0, 0.0, 0.0, 1.0])
    origin = Pose([0.0] * 3, [0.0, 0.0, 0.0, 1.0])
    width, size = 2.0 * core.radius, 0.5 * core.radius
    ends = [end for line in core.lines for end in _piece(line, pose, core.radius)]
    drawn = [
        _marker(header, "disk", _CYLINDER, pose, [width, width, _HEIGHT], [0.2, 0.5, 0.9, 0.8]),
        _marker(header, "goal", _SPHERE, goal, [size] * 3, [0.2, 0.8, 0.3, 0.8]),
    ]
    if ends:
        drawn.append(_marker(header, "lines", _LINES, origin, [_WIDTH, 0.0, 0.0], [0.9, 0.3, 0.2, 0.8], ends))
    return drawn


def _piece(line: Line, pose: Pose, radius: float) -> list[list[float]]:
    """Both ends of the segment of a line near a disk; empty if it is far."""
    _, nx, ny, limit = line
    (x, y, _), reach = pose.position, 2.0 * radius
    distance = limit - nx * x - ny * y
    if abs(distance) > _NEAR * radius:
        return []
    x, y = x + distance * nx, y + distance * ny
    return [[x - reach * ny, y + reach * nx, 0.0], [x + reach * ny, y - reach * nx, 0.0]]


def _marker(
    header: Header,
    name: str,
    kind: int,
    pose: Pose,
    scale: list[float],
    color: list[float],
    points: list[list[float]] | None = None,
) -> Marker:
    return Marker(header, name, 0, kind, 0, pose, scale, color, _LIFETIME, 0, False, points or [])
