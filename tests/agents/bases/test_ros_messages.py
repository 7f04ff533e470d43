"""ROS 2 messages against a second implementation, rosbags', whatever the numbers and the names."""

from __future__ import annotations

import dataclasses
import struct
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

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
from protocol.errors import MessageError

COUNT = 2500  # of each of the four
STORE = get_typestore(Stores.ROS2_JAZZY)
T = STORE.types


class Draw:
    """Random messages: doubles of all magnitudes, names of all lengths, in one or several bytes a letter."""

    def __init__(self) -> None:
        self._rng = np.random.default_rng(1)

    def doubles(self, count: int) -> list[float]:
        exponents = self._rng.integers(-40, 40, count)
        return (self._rng.uniform(-1.0, 1.0, count) * 10.0**exponents).tolist()

    def text(self) -> str:
        return "".join(self._rng.choice(list("abc/_ü漢"), self._rng.integers(0, 20)).tolist())

    def header(self) -> Header:
        return header_at(
            int(self._rng.integers(0, 2**31)) * NANO + int(self._rng.integers(0, NANO)), self.text()
        )

    def velocity(self) -> Velocity:
        return Velocity(self.doubles(3), self.doubles(3))

    def pose(self) -> Pose:
        return Pose(self.doubles(3), self.doubles(4))


def header_of(header: Header) -> Any:
    stamp = T["builtin_interfaces/msg/Time"](*divmod(header.stamp, NANO))
    return T["std_msgs/msg/Header"](stamp, header.frame)


def vector(values: list[float]) -> Any:
    return T["geometry_msgs/msg/Vector3"](*values)


def twist_of(velocity: Velocity) -> Any:
    return T["geometry_msgs/msg/Twist"](vector(velocity.linear), vector(velocity.angular))


def pose_of(pose: Pose) -> Any:
    return T["geometry_msgs/msg/Pose"](
        T["geometry_msgs/msg/Point"](*pose.position), T["geometry_msgs/msg/Quaternion"](*pose.orientation)
    )


def odometry_of(message: Odometry) -> Any:
    return T["nav_msgs/msg/Odometry"](
        header_of(message.header),
        message.child,
        T["geometry_msgs/msg/PoseWithCovariance"](pose_of(message.pose), np.array(message.pose_covariance)),
        T["geometry_msgs/msg/TwistWithCovariance"](
            twist_of(message.velocity), np.array(message.velocity_covariance)
        ),
    )


CASES = {
    "geometry_msgs/msg/Twist": (Velocity, Draw.velocity, twist_of),
    "geometry_msgs/msg/TwistStamped": (
        StampedVelocity,
        lambda draw: StampedVelocity(draw.header(), draw.velocity()),
        lambda m: T["geometry_msgs/msg/TwistStamped"](header_of(m.header), twist_of(m.velocity)),
    ),
    "geometry_msgs/msg/PoseStamped": (
        StampedPose,
        lambda draw: StampedPose(draw.header(), draw.pose()),
        lambda m: T["geometry_msgs/msg/PoseStamped"](header_of(m.header), pose_of(m.pose)),
    ),
    "nav_msgs/msg/Odometry": (
        Odometry,
        lambda draw: Odometry(
            draw.header(), draw.text(), draw.pose(), draw.doubles(36), draw.velocity(), draw.doubles(36)
        ),
        odometry_of,
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_what_is_written_and_read_is_what_rosbags_writes_and_reads(name):
    """10 000 messages in all. Between numbers there may be anything, so rosbags reads what this writes."""
    kind, make, theirs = CASES[name]
    draw = Draw()
    for number in range(COUNT):
        message = make(draw)
        other = theirs(message)
        payload = bytes(STORE.serialize_cdr(other, name, little_endian=bool(number % 4)))
        assert decode(kind, payload) == message
        assert plain(STORE.deserialize_cdr(message.serialize(), name)) == plain(other)


def plain(message: Any) -> Any:
    """Arrays as lists, so that messages can be compared."""
    if dataclasses.is_dataclass(message):
        return {f.name: plain(getattr(message, f.name)) for f in dataclasses.fields(message)}
    return message.tolist() if isinstance(message, np.ndarray) else message


@pytest.mark.parametrize("name", CASES)
def test_damaged_payloads_are_refused(name):
    kind, make, _ = CASES[name]
    payload = make(Draw()).serialize()
    for length in range(len(payload)):
        with pytest.raises(MessageError):
            decode(kind, payload[:length])
    with pytest.raises(MessageError, match="no CDR"):
        decode(kind, b"\1" + payload[1:])


def test_a_text_that_claims_to_be_longer_than_the_message_is_refused():
    with pytest.raises(MessageError, match="no StampedPose"):
        decode(StampedPose, b"\0\1\0\0" + struct.pack("<iII", 1, 2, 2**32 - 1) + b"map\0")
