"""What a robot knows of itself from odometry and poses, and whether it may rely on that.

Odometry says how far the base went, and a pose, whose error is bounded, where it was at some time; odometry
carries that to the present. Whatever is wrong with either stream makes all that was known before void: the
robot stands until both have been sound for `SETTLING` with the base at rest, and then begins anew.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from agents.bases.odometer import Odometer, Place, planar_yaw, wrapped
from agents.bases.ros_messages import NANO, Odometry, StampedPose, decode
from protocol.bodies.kinematics import turned
from protocol.errors import MessageError
from protocol.messages import BaseMotion, Sense, Vector
from protocol.scenario.base import Base
from protocol.scenario.model import Scenario

SETTLING: Final = 0.5  # s for which everything has to be sound
SILENCE: Final = 0.5  # s without odometry after which nothing is known any more
_MOVED: Final = 0.01  # m, by which a base at rest may seem to move
_TURNED: Final = 0.05  # rad, that a direction by odometry may be off besides its share of the turn


class Fix(NamedTuple):
    """A pose together with the odometry of its time."""

    place: Place  # by odometry
    x: float  # m, of the control point in the map
    y: float
    askew: float  # rad, direction in the map less that by odometry


class Senses:
    """Odometry and poses of one robot.

    Attributes:
        note: why nothing is known; "" if all is well.
        anew: whether all is well after it was not, so that what was known before is void.
    """

    def __init__(self, scenario: Scenario, robot: int, base: Base) -> None:
        body, sensing = scenario.body_of(robot), scenario.sensing_of(robot)
        self.note = "waits for odometry and a pose"
        self.anew = False
        self._odometer, self._base, self._offset = Odometer(base, body), base, body.offset
        self._period = scenario.time.step
        self._skew = 2.0 * math.sin(0.5 * sensing.heading)  # off by heading, per way
        self._heading = sensing.heading
        self._bound = sensing.bound + self._skew * body.offset
        self._poses: list[tuple[float, float, float, float]] = []  # stamp, x, y, yaw; not used yet
        self._stamp = -math.inf  # of the newest pose
        self._fix: Fix | None = None
        self._fresh = False  # whether the fix was not read yet
        self._settled_from = math.inf  # s: since when everything is sound
        self._rest: Place | None = None  # by odometry, since then
        self._read: Place | None = None  # where the robot knows itself to have been

    @property
    def sound(self) -> bool:
        """Whether what is read can be relied on."""
        return self.note == ""

    # -- what arrives

    def on_odometry(self, payload: bytes, now: float) -> None:
        """An Odometry arrived."""
        try:
            wrong = self._odometer.take(decode(Odometry, payload), now)
        except MessageError as error:
            wrong = f"odometry: {error}"
        if wrong:
            self.doubt(wrong)
        elif self._settled_from == math.inf:
            self._settled_from, self._rest = now, self._odometer.newest
        elif not self.sound:
            self._watch_rest(now)

    def on_pose(self, payload: bytes) -> None:
        """A PoseStamped arrived."""
        try:
            message = decode(StampedPose, payload)
        except MessageError as error:
            self.doubt(f"pose: {error}")
            return
        yaw, stamp = planar_yaw(message.pose), message.header.stamp / NANO
        if message.header.frame != self._base.map_frame:
            self.doubt(f"a pose in {message.header.frame!r}, not in {self._base.map_frame!r}")
        elif yaw is None:
            self.doubt("a pose that is no number, or not in the plane")
        elif stamp < self._stamp:
            self.doubt(f"the pose goes back in time by {self._stamp - stamp:.3g} s")
        elif stamp > self._stamp:
            self._stamp = stamp
            x, y, _ = message.pose.position
            x, y = x + self._offset * math.cos(yaw), y + self._offset * math.sin(yaw)
            self._poses.append((stamp, x, y, yaw))

    def doubt(self, why: str) -> None:
        """Rely on nothing that was heard so far."""
        self.note, self.anew = why, False
        self._odometer.forget()
        self._poses.clear()
        self._stamp = -math.inf
        self._fix = self._rest = self._read = None
        self._settled_from = math.inf

    # -- what is known

    def look(self, now: float) -> None:
        """Take in the newest pose that odometry encloses, and find out whether all is well."""
        if self._odometer.newest is None:
            return
        if now - self._odometer.arrived > SILENCE:
            self.doubt(f"no odometry for {SILENCE:g} s")
            return
        self._take_poses()
        if not self.sound and self._fix is not None and now >= self._settled_from + SETTLING:
            self.note, self.anew = "", True

    def place(self) -> tuple[Vector, float] | None:
        """Where the control point is, m, and by how much that may be off, m; None if that is not known."""
        fix, newest = self._fix, self._odometer.newest
        if not self.sound or fix is None or newest is None:
            return None
        x, y = self._carried(fix, newest)
        return (x, y), self._bound + self._spread(newest.way - fix.place.way)

    def heading(self) -> float:
        """Which way the base faces in the map as the newest odometry has it, rad; 0 if that is not known."""
        fix, newest = self._fix, self._odometer.newest
        return 0.0 if fix is None or newest is None else wrapped(newest.yaw + fix.askew)

    def age(self, now: float) -> float:
        """How long ago the newest odometry arrived, s."""
        return now - self._odometer.arrived

    def read(self, tick: int, motion: BaseMotion | None, now: float) -> Sense | None:
        """What is known as `tick` begins; None if nothing can be relied on.

        The tick begins for this robot when its newest odometry says, of which the base says that it does
        `motion`.
        """
        self.look(now)
        fix, newest = self._fix, self._odometer.newest
        if not self.sound or fix is None or newest is None or self.age(now) > self._base.age:
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

    def _take_poses(self) -> None:
        """Compare poses with what odometry makes of those before."""
        waiting, self._poses = self._poses, []
        for stamp, x, y, yaw in waiting:
            place, newest = self._odometer.at(stamp), self._odometer.newest
            if newest is None:
                return
            if place is None:
                if stamp > newest.stamp:
                    self._poses.append((stamp, x, y, yaw))
                continue
            fix = Fix(place, x, y, yaw - place.yaw)
            if self._fix is not None and (wrong := self._contradiction(self._fix, fix)):
                self.doubt(wrong)
                return
            self._fix, self._fresh = fix, True

    def _contradiction(self, last: Fix, fix: Fix) -> str:
        """What two poses and the odometry between them say of each other, if not all bounds can be true."""
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

    def _carried(self, fix: Fix, to: Place) -> Vector:
        """Where the control point of a fix is by the odometry since, m."""
        dx, dy = turned(to.x - fix.place.x, to.y - fix.place.y, fix.askew)
        return fix.x + dx, fix.y + dy

    def _spread(self, way: float) -> float:
        """By how much what odometry says of a way may be off in the map, m."""
        return self._odometer.spread(way) + self._skew * way

    def _watch_rest(self, now: float) -> None:
        """Wait for the base to stand before anything is relied on."""
        newest, rest = self._odometer.newest, self._rest
        if newest is None or rest is None:
            return
        if math.hypot(newest.x - rest.x, newest.y - rest.y) > _MOVED:
            self._settled_from, self._rest = now, newest
