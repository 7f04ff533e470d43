"""A base with a ROS 2 interface: topics of velocity, odometry, pose and wishes, with payloads in CDR."""

from __future__ import annotations

import math
import time

from agents.bases import dialects as ros
from agents.bases.dialects import Topic
from agents.bases.drive import OFTEN, Drive, Lease
from agents.bases.ros_messages import StampedVelocity, Velocity, decode, header_at
from agents.bases.senses import Senses
from protocol.bodies.kinematics import turned
from protocol.errors import MessageError
from protocol.messages import LARGEST, STILL, Command, Sense, Tick, Vector
from protocol.scenario.body import DECISION, Base
from protocol.scenario.model import Scenario


class Ros2Base:
    """An external base and localisation. Sans-I/O: takes received payloads, returns payloads to publish."""

    def __init__(self, scenario: Scenario, robot: int, base: Base) -> None:
        body, base = scenario.body_of(robot), base.of(robot)
        twist = ros.STAMPED_TWIST if base.stamped else ros.TWIST
        self._odometry = Topic(base.topic(base.odometry), ros.ODOMETRY)
        self._pose = Topic(base.topic(base.pose), ros.STAMPED_POSE)
        wishes = [Topic(base.topic(base.desired), twist)] if scenario.control.law == "external" else []
        self.topics: tuple[Topic, ...] = (self._odometry, self._pose, *wishes)  # to subscribe to
        self.drives = Topic(base.topic(base.velocity), twist)  # of velocities, which it publishes
        self.due = 0.0  # s, time of the next `on_timer`
        self._base, self._offset = base, body.offset
        self._every = base.timeout / OFTEN
        self.senses = Senses(scenario, robot, base)
        self._drive = Drive(body, base, scenario.time.step)
        self._duration = scenario.world.lease
        self._lease, self._life = Lease(self._duration), 0
        self._heading = 0.0  # in the map at the effect of the present tick's command, rad
        self._begun = -math.inf
        self._shared = False

    def on_message(self, topic: Topic, payload: bytes, now: float) -> Vector | None:
        """Receive a message of one of `topics`; returns a wish for an external law, m/s, if any."""
        if self._shared:
            return None
        if topic == self._odometry:
            self.senses.on_odometry(payload, now)
        elif topic == self._pose:
            self.senses.on_pose(payload)
        else:
            return self._wish(payload)
        return None

    def _wish(self, payload: bytes) -> Vector | None:
        """Velocity of the control point in the map for a Twist, m/s; None without a known heading."""
        stamped = self._base.stamped
        twist = decode(StampedVelocity, payload).velocity if stamped else decode(Velocity, payload)
        ahead = twist.linear[0]
        aside = self._offset * twist.angular[2] if self._offset > 0.0 else twist.linear[1]
        if not math.hypot(ahead, aside) <= LARGEST:
            raise MessageError("range", "a velocity that is no number")
        return turned(ahead, aside, self.senses.heading()) if self.senses.sound else None

    def begin(self, tick: Tick, now: float) -> Sense | None:
        """Begin a tick; returns the odometry and the measurement, None if they are not trusted."""
        if tick.incarnation != self._life:
            self._lease, self._life = Lease(self._duration), tick.incarnation
        self._lease.heard(tick.heard)
        self.senses.look(now)
        self._begun = now
        self._heading = self.senses.heading() + self._drive.turning(self.senses.age(now), now)
        motion = self._drive.motion(self._heading, now)
        return None if motion is None else self.senses.read(tick.tick, motion, now)

    def obey(self, command: Command, now: float) -> bytes:
        """Execute the Command of the newest tick, before it is sent; returns the payload to publish at
        once."""
        if command.may_move:  # otherwise the coordinator may declare its robot static at once
            self._lease.sent(command.tick, now)
        late = self.senses.is_late(now) or now - self._begun > DECISION
        velocity = command.velocity if self.senses.sound and not late else STILL
        self._drive.command(velocity, self._heading, now, self._lease.until)
        return self._advance(now)

    def share(self, shared: bool) -> None:
        """Set whether another process drives this base: then its data is not trusted."""
        self._shared = shared
        if shared:
            self.senses.invalidate(f"another process drives {self.drives.name}, of this or another run")

    def stand(self, now: float) -> bytes:
        """Brake, outside of a tick; returns the payload to publish at once."""
        self._drive.command(STILL, self._heading, now, now)
        return self._advance(now)

    def on_timer(self, now: float) -> bytes:
        """The payload to publish by now."""
        self.senses.look(now)
        return self._advance(now) if self.senses.sound else self.stand(now)

    def _advance(self, now: float) -> bytes:
        """The velocity for the base by now."""
        self._drive.advance(now)
        self.due = min(now + self._every, self._drive.due)
        ahead, aside = self._drive.velocity
        if self._offset > 0.0:
            velocity = Velocity([ahead, 0.0, 0.0], [0.0, 0.0, aside / self._offset])
        else:
            velocity = Velocity([ahead, aside, 0.0], [0.0, 0.0, 0.0])
        if self._base.stamped:
            return StampedVelocity(header_at(time.time_ns(), self._base.base_frame), velocity).serialize()
        return velocity.serialize()
