"""A robot's topics for tools of ROS 2, such as RViz: its pose, markers, a stop and a goal."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import Final

import msgspec

from agents.bases import dialects as ros
from agents.bases.base import Shown
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
from protocol.bodies.kinematics import turned
from protocol.errors import MessageError
from protocol.messages import LARGEST, Line
from protocol.scenario.body import Base

PERIOD: Final = 0.1  # s, least time between two transforms
_DRAWN: Final = 5  # transforms for each drawing
_SPHERE, _CYLINDER, _LINES = 2, 3, 5
_HEIGHT, _WIDTH = 0.05, 0.005  # m, of drawings
_NEAR: Final = 6.0  # radii, drawn distance of a line
_LIFETIME: Final = 2  # s, lifetime of drawings


class RosTools:
    """The topics of one robot for tools. Sans-I/O.

    The frame `<namespace>/disk` is its disk's; its only parent is the map.

    Args:
        base: names of frames and topics, for this robot.
        robot: own id.

    Attributes:
        hears, tells: topics to subscribe to, and to publish.
        stopped: whether a message stopped the robot, and none has released it.
    """

    def __init__(self, base: Base, robot: int) -> None:
        self._base, self._robot = base, robot
        self._frame = f"{base.namespace.strip('/')}/disk".lstrip("/")
        self._stop = Topic(base.topic("disknav/stop"), ros.BOOL)
        self._goal = Topic(base.topic("goal_pose"), ros.STAMPED_POSE)
        self._tf = Topic(base.topic("/tf"), ros.TF)
        self._odometry = Topic(base.topic("disknav/odom"), ros.ODOMETRY)
        self._markers = Topic(base.topic("disknav/markers"), ros.MARKERS)
        self.hears = (self._stop, self._goal)
        self.tells = (self._tf, self._odometry, self._markers)
        self.stopped = False
        self._due, self._told = -math.inf, 0

    def hear(self, topic: Topic, payload: bytes) -> bytes:
        """Receive a message; returns the request for an operation that follows, empty if none. Raises
        MessageError, also for a goal in another frame than the map.
        """
        if topic == self._stop:
            self.stopped = decode(Flag, payload).data
            return b""
        message = decode(StampedPose, payload)
        x, y, _ = message.pose.position
        if message.header.frame != self._base.map_frame:
            text = f"a goal in {message.header.frame!r}, not in {self._base.map_frame!r}"
            raise MessageError("range", text)
        if not math.hypot(x, y) <= LARGEST:
            raise MessageError("range", "a goal that is no number")
        return msgspec.msgpack.encode({"goal": {"robot": self._robot, "points": [[x, y]]}})

    def is_due(self, now: float) -> bool:
        """Whether `tell` is due at `now`, s."""
        return now >= self._due

    def tell(self, robot: Shown, now: float) -> Iterator[tuple[Topic, bytes]]:
        """Topics and payloads to publish by `now`, s."""
        self._due = now + PERIOD
        header, half = header_at(time.time_ns(), self._base.map_frame), 0.5 * robot.heading
        pose = Pose([*robot.position, 0.0], [0.0, 0.0, math.sin(half), math.cos(half)])
        moved = Transform(header, self._frame, pose.position, pose.orientation)
        yield self._tf, Transforms([moved]).serialize()
        yield self._odometry, self._located(header, pose, robot).serialize()
        if self._told % _DRAWN == 0:
            yield self._markers, Markers(_drawn(header, pose, robot)).serialize()
        self._told += 1

    def _located(self, header: Header, pose: Pose, robot: Shown) -> Odometry:
        """The pose; the squared bound is an upper bound of the variance."""
        spread = [0.0] * 36
        spread[0] = spread[7] = robot.bound * robot.bound
        twist = Velocity([*turned(*robot.velocity, -robot.heading), 0.0], [0.0] * 3)
        return Odometry(header, self._frame, pose, spread, twist, [0.0] * 36)


def _drawn(header: Header, pose: Pose, robot: Shown) -> list[Marker]:
    goal = Pose([*robot.goal, 0.0], [0.0, 0.0, 0.0, 1.0])
    origin = Pose([0.0] * 3, [0.0, 0.0, 0.0, 1.0])
    width, size = 2.0 * robot.radius, 0.5 * robot.radius
    ends = [end for line in robot.lines for end in _piece(line, robot)]
    drawn = [
        _marker(header, "disk", _CYLINDER, pose, [width, width, _HEIGHT], [0.2, 0.5, 0.9, 0.8]),
        _marker(header, "goal", _SPHERE, goal, [size] * 3, [0.2, 0.8, 0.3, 0.8]),
    ]
    if ends:
        drawn.append(_marker(header, "lines", _LINES, origin, [_WIDTH, 0.0, 0.0], [0.9, 0.3, 0.2, 0.8], ends))
    return drawn


def _piece(line: Line, robot: Shown) -> list[list[float]]:
    """Both ends of the segment of a line near a disk; empty if it is far."""
    _, nx, ny, limit = line
    (x, y), reach = robot.position, 2.0 * robot.radius
    away = limit - nx * x - ny * y
    if abs(away) > _NEAR * robot.radius:
        return []
    x, y = x + away * nx, y + away * ny
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
