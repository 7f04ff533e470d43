"""The odometry of a base: a stream of poses in a frame of its own, of which nothing is believed unseen."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import Final, NamedTuple

from agents.bases.ros_messages import NANO, Odometry, Pose
from protocol.scenario.base import Base
from protocol.scenario.body import Body

KEPT: Final = 400  # messages; a pose that is older than these is of no use
_SLACK: Final = 0.005  # m, that a message may be off the one before, besides what the base can do
_TURN_SLACK: Final = 0.02  # rad
_LEVEL: Final = 0.01  # by which a quaternion may miss unit length, or leave the plane


class Place(NamedTuple):
    """Where the control point is by odometry, m, which way the base faces, rad, how far it has gone, m."""

    stamp: float  # s, by the clock of the base
    x: float
    y: float
    yaw: float
    way: float


class Odometer:
    """Checks and keeps odometry.

    Args:
        base: frames that messages must name.
        body: how fast it can be, and where the control point is.

    Attributes:
        newest: the newest place, None before any.
        arrived: when that came, s, by the clock of this process.
    """

    def __init__(self, base: Base, body: Body) -> None:
        self.newest: Place | None = None
        self.arrived = -math.inf
        self._frames = base.odometry_frame, base.base_frame
        self._offset = body.offset
        self._share, self._drift = body.odometry, body.drift
        self._speed, self._rate = body.speed, 0.0
        if body.track > 0.0:
            self._speed *= max(1.0, 2.0 * body.offset / body.track)
            self._rate = 2.0 * body.speed / body.track
        self._places: deque[Place] = deque(maxlen=KEPT)

    def forget(self) -> None:
        """Begin anew with the next message."""
        self.newest = None
        self._places.clear()

    def take(self, message: Odometry, now: float) -> str:
        """Take in a message that arrived `now`; what is wrong with it, "" if nothing."""
        yaw = planar_yaw(message.pose)
        wrong = self._malformed(message, yaw)
        if wrong or yaw is None:
            return wrong
        x, y, _ = message.pose.position
        x, y = x + self._offset * math.cos(yaw), y + self._offset * math.sin(yaw)
        stamp, last = message.header.stamp / NANO, self.newest
        self.arrived = now
        if last is None:
            self._keep(Place(stamp, x, y, yaw, 0.0))
            return ""
        passed, step = stamp - last.stamp, math.hypot(x - last.x, y - last.y)
        turn = wrapped(yaw - last.yaw)
        wrong = self._impossible(passed, step, abs(turn))
        if not wrong and passed > 0.0:
            self._keep(Place(stamp, x, y, last.yaw + turn, last.way + step))
        return wrong

    def _malformed(self, message: Odometry, yaw: float | None) -> str:
        """What is wrong with a message by itself; "" if nothing."""
        frame, child = message.header.frame, message.child
        if (frame, child) != self._frames:
            known, of = self._frames
            return f"odometry of {child!r} in {frame!r}, not of {of!r} in {known!r}"
        speeds = (*message.velocity.linear, *message.velocity.angular)
        if yaw is None or not all(map(math.isfinite, speeds)):
            return "odometry that is no number, or not in the plane"
        return ""

    def _impossible(self, passed: float, step: float, turn: float) -> str:
        """What no base can do in a time, s: a step, m, or a turn, rad; "" if it can."""
        if passed < 0.0:
            return f"odometry goes back in time by {-passed:.3g} s"
        if step > self._speed * passed * (1.0 + self._share) + self._drift + _SLACK:
            return f"odometry jumps by {step:.3g} m in {passed:.3g} s"
        if self._rate and turn > self._rate * passed * (1.0 + self._share) + _TURN_SLACK:
            return f"odometry turns by {turn:.3g} rad in {passed:.3g} s"
        return ""

    def at(self, stamp: float) -> Place | None:
        """The place of a time that the kept messages enclose; None of any other."""
        places = self._places
        index = bisect_left(places, stamp, key=lambda place: place.stamp)
        if index == len(places) or (index == 0 and places[0].stamp != stamp):
            return None
        after = places[index]
        if after.stamp == stamp:
            return after
        before = places[index - 1]
        part = (stamp - before.stamp) / (after.stamp - before.stamp)
        x, y, yaw, way = (a + part * (b - a) for a, b in zip(before[1:], after[1:], strict=True))
        return Place(stamp, x, y, yaw, way)

    def spread(self, way: float) -> float:
        """By how much odometry may be off after a way, m."""
        return (self._share * way + self._drift) / (1.0 - self._share)

    def _keep(self, place: Place) -> None:
        self.newest = place
        self._places.append(place)


def planar_yaw(pose: Pose) -> float | None:
    """The direction of a pose in the plane, rad; None if it is none, or none of the plane."""
    x, y, z, w = pose.orientation
    if not all(map(math.isfinite, (*pose.position, x, y, z, w))):
        return None
    if abs(math.hypot(x, y, z, w) - 1.0) > _LEVEL or x * x + y * y > _LEVEL:
        return None
    return 2.0 * math.atan2(z, w)


def wrapped(angle: float) -> float:
    """The same angle between -pi and pi, rad."""
    return math.remainder(angle, math.tau)
