"""Driving a square with a base, and noting what was told, what odometry says, and what poses say.

Sans-I/O: it is told what arrives and asked what is to be sent. At the end of the last side nothing is sent
any more, so that the base shows its own timeout.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from agents.bases.ros_messages import (
    NANO,
    Header,
    Odometry,
    Pose,
    StampedPose,
    StampedVelocity,
    Velocity,
    decode,
    header_at,
)
from agents.bases.senses import planar_yaw, wrapped
from protocol.scenario.body import Base

PAUSE: Final = 1.5  # s at rest between two motions, in which poses are compared
EVERY: Final = 0.05  # s between two velocities
SILENCE: Final = 3.0  # s that the base is given to stop by itself


class Move(NamedTuple):
    """Something to do for a while."""

    duration: float  # s
    ahead: float  # m/s
    rate: float  # rad/s
    told: bool = True  # False: nothing is sent


class Row(NamedTuple):
    """A place at a time, by odometry or by a pose."""

    time: float  # s, when it arrived
    stamp: float  # s, by the clock of its publisher
    x: float  # m
    y: float
    yaw: float  # rad, without jumps
    ahead: float = 0.0  # m/s, of odometry
    rate: float = 0.0  # rad/s, of odometry


class Log(NamedTuple):
    """Everything that was noted."""

    moves: list[tuple[float, Move]]  # s, when it began
    odometry: list[Row]
    poses: list[Row]


def square(side: float, speed: float, rate: float) -> list[Move]:
    """Four sides of `side` m, four corners, and a last side that is not ended by a command."""
    rest = Move(PAUSE, 0.0, 0.0)
    moves = [rest]
    for _ in range(4):
        moves += [Move(side / speed, speed, 0.0), rest, Move(0.5 * math.pi / rate, 0.0, rate), rest]
    return [*moves, Move(0.5 * side / speed, speed, 0.0), Move(SILENCE, 0.0, 0.0, told=False)]


class Driver:
    """Drives through moves.

    Args:
        base: its topics and frames.
        robot: the id that stands for `{id}` in their names.
        moves: what to do, once odometry and a pose have come.

    Attributes:
        keys: under which it wants to hear.
        tells: the key under which it sends.
        due: when `wake` wants to be called, s.
        finished: whether it is over.
    """

    def __init__(self, base: Base, robot: int, moves: list[Move]) -> None:
        base = base.of(robot)
        self._odometry, self._pose = base.key(base.odometry), base.key(base.pose)
        self.keys = (self._odometry, self._pose)
        self.tells = base.key(base.velocity)
        self.due = 0.0
        self.finished = False
        self.log = Log([], [], [])
        self._base, self._ahead = base, list(reversed(moves))
        self._until = math.inf

    @property
    def waits_for(self) -> str:
        """What has not come yet; "" if all is there."""
        missing = [key for key, rows in zip(self.keys, self.log[1:], strict=True) if not rows]
        return " and ".join(missing)

    def hear(self, key: str, payload: bytes, now: float) -> None:
        """Something arrived; raises MessageError if it is not what it should be."""
        if key == self._odometry:
            message = decode(Odometry, payload)
            ahead, rate = message.velocity.linear[0], message.velocity.angular[2]
            self._note(self.log.odometry, now, message.header, message.pose, ahead, rate)
        elif key == self._pose:
            located = decode(StampedPose, payload)
            self._note(self.log.poses, now, located.header, located.pose)

    def _note(self, rows: list[Row], now: float, header: Header, pose: Pose, *speeds: float) -> None:
        yaw = planar_yaw(pose)
        if yaw is not None:
            last = rows[-1].yaw if rows else 0.0
            x, y, _ = pose.position
            rows.append(Row(now, header.stamp / NANO, x, y, last + wrapped(yaw - last), *speeds))

    def wake(self, now: float) -> list[bytes]:
        """What is to be sent by now."""
        self.due = now + EVERY
        if self.waits_for:
            return []
        if not self.log.moves or now >= self._until:
            if not self._ahead:
                self.finished = True
                return [self._message(0.0, 0.0, now)]
            move = self._ahead.pop()
            self.log.moves.append((now, move))
            self._until = now + move.duration
        move = self.log.moves[-1][1]
        self.due = min(self.due, self._until)
        return [self._message(move.ahead, move.rate, now)] if move.told else []

    def _message(self, ahead: float, rate: float, now: float) -> bytes:
        velocity = Velocity([ahead, 0.0, 0.0], [0.0, 0.0, rate])
        if self._base.stamped:
            header = header_at(round(now * NANO), self._base.base_frame)
            return StampedVelocity(header, velocity).serialize()
        return velocity.serialize()
