"""A robot's position from odometry and poses, with checks of both.

Odometry measures displacement, and a pose, with a bounded error, the position at some time; odometry carries
it to the present. Any fault of either stream invalidates both: the robot stands until both have been free of
faults for `SETTLING` with the base at rest, and then starts again.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import Final, NamedTuple

from agents.bases.ros_messages import NANO, Odometry, Pose, StampedPose, decode
from protocol.bodies.kinematics import turned
from protocol.errors import MessageError
from protocol.messages import BaseMotion, Sense, Vector
from protocol.scenario.body import Base, Body
from protocol.scenario.model import Scenario

KEPT: Final = 400  # messages kept; older poses are ignored
_SLACK: Final = 0.005  # m, tolerated beyond the base's motion between two messages
_TURN_SLACK: Final = 0.02  # rad
SETTLING: Final = 0.5  # s without faults before a start
SILENCE: Final = 0.5  # s without timely odometry after which the position is unknown
PAUSE: Final = 0.25  # s between two odometry messages after which a restart of their publisher is considered
DRIFT: Final = 5e-4  # s per second by which two clocks may diverge, as by slewing
_EARLY: Final = 0.01  # s beyond `latency` by which a message may be less late than all before
_MOVED: Final = 0.01  # m, tolerated motion of a base at rest
_TURNED: Final = 0.05  # rad, error of a direction by odometry besides its share of the turn
_LEVEL: Final = 0.01  # tolerance of a quaternion's length and tilt


class OdometryPlace(NamedTuple):
    """Position of the control point by odometry, m, heading of the base, rad, and path length, m."""

    stamp: float  # s, by the clock of the base
    x: float
    y: float
    yaw: float
    way: float


class LinkDelay:
    """Age of a stream's messages, whose stamps are from another clock.

    Arrival less stamp is the difference of the clocks plus the delay. The least value seen so far has the
    least delay. It may rise by `DRIFT`, since clocks drift apart; so after some minutes a lasting delay
    becomes the least one. A stamp before the last one raises it by the difference: the clock was set back, or
    one message of a late link has overtaken another, which makes none of them young.
    """

    def __init__(self) -> None:
        self._least = math.inf  # s
        # How much less the newest message was delayed than all before, s; infinite for the first.
        self.ahead = math.inf
        self._stamp = self._arrived = -math.inf

    def take(self, stamp: float, now: float) -> None:
        """Note a message with a stamp, s, that arrived `now`."""
        self._least += DRIFT * (now - self._arrived)
        if stamp < self._stamp:
            self._least += self._stamp - stamp + now - self._arrived
        self.ahead = self._least - (now - stamp)
        self._least = min(self._least, now - stamp)
        self._stamp, self._arrived = stamp, now

    def age(self, stamp: float, now: float) -> float:
        """Age of a stamp, s, beyond the least delay."""
        return now - stamp - self._least


class Odometer:
    """Checks and keeps odometry, a stream of poses in its own frame."""

    def __init__(self, base: Base, body: Body) -> None:
        self.newest: OdometryPlace | None = None
        self.arrived = -math.inf  # s, by the clock of this process, of the last message
        self.timely = -math.inf  # the same of the last one that was young enough to begin a tick
        self._frames = base.odometry_frame, base.base_frame
        self._link, self._least, self._latency = LinkDelay(), base.delay, base.latency
        self.oldest = base.age + base.latency  # greatest age with which a tick may begin, s
        self._offset = body.offset
        self._share, self._drift = body.odometry, body.drift
        self._speed, self._rate = body.speed, 0.0
        if body.track > 0.0:
            self._speed *= max(1.0, 2.0 * body.offset / body.track)
            self._rate = 2.0 * body.speed / body.track
        self._places: deque[OdometryPlace] = deque(maxlen=KEPT)

    def forget(self) -> None:
        """Restart with the next message."""
        self.newest = None
        self._places.clear()

    def take(self, message: Odometry, now: float) -> str:
        """Add a message that arrived `now`; returns its fault, "" if none."""
        yaw = planar_yaw(message.pose)
        wrong = self._malformed(message, yaw)
        if wrong or yaw is None:
            return wrong
        x, y, _ = message.pose.position
        x, y = x + self._offset * math.cos(yaw), y + self._offset * math.sin(yaw)
        stamp, last = message.header.stamp / NANO, self.newest
        self._link.take(stamp, now)
        since, self.arrived = now - self.arrived, now
        if self._least + self._link.age(stamp, now) <= self.oldest:
            self.timely = now
        else:
            since = 0.0  # a link that was slow may be why nothing came
        if last is None:
            self._keep(OdometryPlace(stamp, x, y, yaw, 0.0))
            return ""
        passed, step = stamp - last.stamp, math.hypot(x - last.x, y - last.y)
        turn = wrapped(yaw - last.yaw)
        wrong = self._restarted(max(passed, since)) or self._impossible(passed, step, abs(turn))
        if not wrong and passed > 0.0:
            self._keep(OdometryPlace(stamp, x, y, last.yaw + turn, last.way + step))
        return wrong

    def age(self, now: float) -> float:
        """Age of the newest place, s; infinite before any."""
        return math.inf if self.newest is None else self._least + self._link.age(self.newest.stamp, now)

    def _malformed(self, message: Odometry, yaw: float | None) -> str:
        """Fault of a message by itself; "" if none."""
        frame, child = message.header.frame, message.child
        if (frame, child) != self._frames:
            known, of = self._frames
            return f"odometry of {child!r} in {frame!r}, not of {of!r} in {known!r}"
        speeds = (*message.velocity.linear, *message.velocity.angular)
        if yaw is None or not all(map(math.isfinite, speeds)):
            return "odometry that is no number, or not in the plane"
        return ""

    def _restarted(self, passed: float) -> str:
        """Sign that the publisher of a message, some time, s, after the last one by the clock of either or by
        that of this process, was restarted; "" if none.

        A restarted publisher may have another clock, and put its origin at the position of the base.
        """
        if passed >= PAUSE:
            return f"odometry pauses for {passed:.3g} s"
        if self._link.ahead > self._latency + _EARLY:
            return f"the clock of odometry jumps ahead by {self._link.ahead:.3g} s"
        return ""

    def _impossible(self, passed: float, step: float, turn: float) -> str:
        """A step, m, or a turn, rad, that no base can make in a time, s; "" if there is none."""
        if passed < 0.0:
            return f"odometry goes back in time by {-passed:.3g} s"
        if step > self._speed * passed * (1.0 + self._share) + self._drift + _SLACK:
            return f"odometry jumps by {step:.3g} m in {passed:.3g} s"
        if self._rate and turn > self._rate * passed * (1.0 + self._share) + _TURN_SLACK:
            return f"odometry turns by {turn:.3g} rad in {passed:.3g} s"
        return ""

    def at(self, stamp: float) -> OdometryPlace | None:
        """The interpolated place of a time within the kept messages, otherwise None."""
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
        return OdometryPlace(stamp, x, y, yaw, way)

    def spread(self, way: float) -> float:
        """Error bound of odometry over a path, m."""
        return (self._share * way + self._drift) / (1.0 - self._share)

    def _keep(self, place: OdometryPlace) -> None:
        self.newest = place
        self._places.append(place)


def planar_yaw(pose: Pose) -> float | None:
    """The direction of a pose in the plane, rad; None if it is invalid or not planar."""
    x, y, z, w = pose.orientation
    if not all(map(math.isfinite, (*pose.position, x, y, z, w))):
        return None
    if abs(math.hypot(x, y, z, w) - 1.0) > _LEVEL or x * x + y * y > _LEVEL:
        return None
    return 2.0 * math.atan2(z, w)


def wrapped(angle: float) -> float:
    """The same angle between -pi and pi, rad."""
    return math.remainder(angle, math.tau)


class Fix(NamedTuple):
    """A pose together with the odometry of its time."""

    place: OdometryPlace  # by odometry
    x: float  # m, of the control point in the map
    y: float
    askew: float  # rad, direction in the map less that by odometry


class Senses:
    """Odometry and poses of one robot."""

    def __init__(self, scenario: Scenario, robot: int, base: Base) -> None:
        body, sensing = scenario.body_of(robot), scenario.sensing_of(robot)
        self.fault = "waits for odometry and a pose"  # why the robot stands, its position unknown; "" if none
        self._anew = False
        self._odometer, self._base, self._offset = Odometer(base, body), base, body.offset
        self._period = scenario.time.step
        self._skew = 2.0 * math.sin(0.5 * sensing.heading)  # error by heading, per length
        self._heading = sensing.heading
        self._bound = sensing.bound + self._skew * body.offset
        self._poses: deque[tuple[float, float, float, float]] = deque(maxlen=KEPT)  # stamp, x, y, yaw; unused
        self._stamp = -math.inf  # stamp of the newest pose
        self._fix: Fix | None = None
        self._fresh = False  # whether the fix is unread
        self._rest: OdometryPlace | None = None  # by odometry, since the streams are free of faults
        self._settled_from = math.inf  # s, begin of that time
        self._read: OdometryPlace | None = None  # known past positions

    @property
    def sound(self) -> bool:
        """Whether both streams are free of faults."""
        return self.fault == ""

    # -- received messages

    def on_odometry(self, payload: bytes, now: float) -> None:
        """Receive an Odometry."""
        try:
            wrong = self._odometer.take(decode(Odometry, payload), now)
        except MessageError as error:
            wrong = f"odometry: {error}"
        newest, rest = self._odometer.newest, self._rest
        if wrong:
            self.invalidate(wrong)
        elif newest is None or rest is None or math.hypot(newest.x - rest.x, newest.y - rest.y) > _MOVED:
            self._settled_from, self._rest = now, newest

    def on_pose(self, payload: bytes) -> None:
        """Receive a PoseStamped."""
        try:
            message = decode(StampedPose, payload)
        except MessageError as error:
            self.invalidate(f"pose: {error}")
            return
        yaw, stamp = planar_yaw(message.pose), message.header.stamp / NANO
        if message.header.frame != self._base.map_frame:
            self.invalidate(f"a pose in {message.header.frame!r}, not in {self._base.map_frame!r}")
        elif yaw is None:
            self.invalidate("a pose that is no number, or not in the plane")
        elif stamp < self._stamp:
            self.invalidate(f"the pose goes back in time by {self._stamp - stamp:.3g} s")
        elif stamp > self._stamp:
            self._stamp = stamp
            x, y, _ = message.pose.position
            x, y = x + self._offset * math.cos(yaw), y + self._offset * math.sin(yaw)
            self._poses.append((stamp, x, y, yaw))

    def invalidate(self, why: str) -> None:
        """Discard all odometry and poses so far."""
        self.fault, self._anew = why, False
        self._odometer.forget()
        self._poses.clear()
        self._stamp = -math.inf
        self._fix = self._rest = self._read = None

    # -- results

    def take_reset(self) -> bool:
        """Whether a fault has ended, so that earlier estimates are void; True once."""
        anew, self._anew = self._anew, False
        return anew

    def look(self, now: float) -> None:
        """Apply the newest pose within the kept odometry, and check both streams."""
        newest = self._odometer.newest
        if newest is None:
            return
        if now - self._odometer.timely > SILENCE:
            silent = now - self._odometer.arrived > SILENCE
            late = "odometry has become later, by more than `base.age` allows"
            self.invalidate(f"no odometry for {SILENCE:g} s" if silent else late)
            return
        self._take_poses(newest)
        if not self.sound and self._fix is not None and now >= self._settled_from + SETTLING:
            self.fault, self._anew = "", True

    def place(self) -> tuple[Vector, float] | None:
        """Position of the control point and its error bound, m; None if unknown."""
        fix, newest = self._fix, self._odometer.newest
        if not self.sound or fix is None or newest is None:
            return None
        x, y = self._carried(fix, newest)
        return (x, y), self._bound + self._spread(newest.way - fix.place.way)

    def heading(self) -> float:
        """Heading of the base in the map by the newest odometry, rad; 0 if unknown."""
        fix, newest = self._fix, self._odometer.newest
        return 0.0 if fix is None or newest is None else wrapped(newest.yaw + fix.askew)

    def age(self, now: float) -> float:
        """Age of the newest odometry, s."""
        return self._odometer.age(now)

    def is_late(self, now: float) -> bool:
        """Whether the newest odometry is too old to move by."""
        return self.age(now) > self._odometer.oldest

    def read(self, tick: int, motion: BaseMotion | None, now: float) -> Sense | None:
        """Odometry and measurement as `tick` begins, after `look`; None if they are not trusted.

        The tick begins for this robot at the stamp of its newest odometry, at which the base executes
        `motion`.
        """
        fix, newest = self._fix, self._odometer.newest
        if not self.sound or fix is None or newest is None or self.is_late(now):
            return None
        last, self._read = self._read, newest
        moved, off = (0.0, 0.0), 0.0
        if last is not None:
            moved = turned(newest.x - last.x, newest.y - last.y, fix.askew)
            ticks = max(1.0, (newest.stamp - last.stamp) / self._period)
            off = self._spread(newest.way - last.way) + (ticks - 1.0) * self._odometer.spread(0.0)
        known = self.place() if self._fresh else None
        self._fresh = False
        position, bound = (None, self._bound) if known is None else known
        return Sense(position, tick, bound, moved, off, motion)

    # -- inside

    def _take_poses(self, newest: OdometryPlace) -> None:
        """Compare poses with earlier ones, carried forward by odometry, which has come up to `newest`."""
        waiting = list(self._poses)
        self._poses.clear()
        for stamp, x, y, yaw in waiting:
            place = self._odometer.at(stamp)
            if place is None:
                if stamp > newest.stamp:
                    self._poses.append((stamp, x, y, yaw))
                continue
            fix = Fix(place, x, y, yaw - place.yaw)
            if self._fix is not None and (wrong := self._contradiction(self._fix, fix)):
                self.invalidate(wrong)
                return
            self._fix, self._fresh = fix, True

    def _contradiction(self, last: Fix, fix: Fix) -> str:
        """How two poses and the odometry between them violate their bounds; "" if they do not."""
        x, y = self._carried(last, fix.place)
        gap = (
            math.hypot(fix.x - x, fix.y - y)
            - 2.0 * self._bound
            - self._spread(fix.place.way - last.place.way)
        )
        if gap > 0.0:
            return f"a pose and odometry exclude each other by {gap:.2g} m: a stated bound is wrong"
        off = abs(wrapped(fix.askew - last.askew)) - 2.0 * self._heading - _TURNED
        if off > 0.0:
            return f"a pose and odometry exclude each other by {off:.2g} rad: a stated bound is wrong"
        return ""

    def _carried(self, fix: Fix, to: OdometryPlace) -> Vector:
        """Position of the control point of a fix, carried forward by odometry, m."""
        dx, dy = turned(to.x - fix.place.x, to.y - fix.place.y, fix.askew)
        return fix.x + dx, fix.y + dy

    def _spread(self, way: float) -> float:
        """Error bound in the map of odometry over a path, m."""
        return self._odometer.spread(way) + self._skew * way
