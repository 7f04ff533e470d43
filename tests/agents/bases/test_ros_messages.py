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
    Flag,
    Header,
    Marker,
    Markers,
    Odometry,
    Pose,
    StampedPose,
    StampedVelocity,
    Transform,
    Transforms,
    Velocity,
    decode,
    header_at,
)
from protocol.errors import MessageError

COUNT = 200  # of each type
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

    def transforms(self) -> Transforms:
        return Transforms(
            [
                Transform(self.header(), self.text(), self.doubles(3), self.doubles(4))
                for _ in range(self._rng.integers(3))
            ]
        )

    def markers(self) -> Markers:
        return Markers([self.marker() for _ in range(self._rng.integers(3))])

    def marker(self) -> Marker:
        numbers = self._rng.integers(-(2**31), 2**31, 4).tolist()
        color = np.float32(self._rng.uniform(0.0, 1.0, 4)).tolist()
        points = [self.doubles(3) for _ in range(self._rng.integers(4))]
        locked = bool(self._rng.integers(2))
        return Marker(
            self.header(),
            self.text(),
            *numbers[:3],
            self.pose(),
            self.doubles(3),
            color,
            numbers[3],
            7,
            locked,
            points,
        )


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


def flag_of(message: Flag) -> Any:
    return T["std_msgs/msg/Bool"](message.data)


def transforms_of(message: Transforms) -> Any:
    moved = T["geometry_msgs/msg/Transform"]
    return T["tf2_msgs/msg/TFMessage"](
        [
            T["geometry_msgs/msg/TransformStamped"](
                header_of(each.header),
                each.child,
                moved(vector(each.translation), T["geometry_msgs/msg/Quaternion"](*each.rotation)),
            )
            for each in message.transforms
        ]
    )


def markers_of(message: Markers) -> Any:
    bytes_of = np.array([], dtype=np.uint8)
    header = T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](0, 0), "")
    return T["visualization_msgs/msg/MarkerArray"](
        [
            T["visualization_msgs/msg/Marker"](
                header_of(each.header),
                each.namespace,
                each.id,
                each.type,
                each.action,
                pose_of(each.pose),
                vector(each.scale),
                T["std_msgs/msg/ColorRGBA"](*each.color),
                T["builtin_interfaces/msg/Duration"](each.lifetime_sec, each.lifetime_nanosec),
                each.frame_locked,
                [T["geometry_msgs/msg/Point"](*point) for point in each.points],
                [],
                "",
                T["sensor_msgs/msg/CompressedImage"](header, "", bytes_of),
                [],
                "",
                "",
                T["visualization_msgs/msg/MeshFile"]("", bytes_of),
                False,
            )
            for each in message.markers
        ]
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
    "std_msgs/msg/Bool": (Flag, lambda draw: Flag(bool(draw.doubles(1)[0] > 0.0)), flag_of),
    "tf2_msgs/msg/TFMessage": (Transforms, Draw.transforms, transforms_of),
    "visualization_msgs/msg/MarkerArray": (Markers, Draw.markers, markers_of),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_what_is_written_and_read_is_what_rosbags_writes_and_reads(name):
    """Between numbers there may be anything, so rosbags reads what this writes."""
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
    if isinstance(message, list):
        return [plain(each) for each in message]
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
    decode(kind, payload + bytes(3))  # which some fill the last word with
    with pytest.raises(MessageError, match=f"{len(payload) + 4} bytes, of which"):
        decode(kind, payload + bytes(4))


def test_a_text_that_claims_to_be_longer_than_the_message_is_refused():
    with pytest.raises(MessageError, match="no StampedPose"):
        decode(StampedPose, b"\0\1\0\0" + struct.pack("<iII", 1, 2, 2**32 - 1) + b"map\0")
