"""ROS 2 messages against a second implementation, rosbags', whatever the numbers and the names."""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Callable, Iterator
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


CASES: dict[str, tuple[type, Callable[[Draw], Any]]] = {
    "geometry_msgs/msg/Twist": (Velocity, Draw.velocity),
    "geometry_msgs/msg/TwistStamped": (
        StampedVelocity,
        lambda draw: StampedVelocity(draw.header(), draw.velocity()),
    ),
    "geometry_msgs/msg/PoseStamped": (StampedPose, lambda draw: StampedPose(draw.header(), draw.pose())),
    "nav_msgs/msg/Odometry": (
        Odometry,
        lambda draw: Odometry(
            draw.header(), draw.text(), draw.pose(), draw.doubles(36), draw.velocity(), draw.doubles(36)
        ),
    ),
    "std_msgs/msg/Bool": (Flag, lambda draw: Flag(bool(draw.doubles(1)[0] > 0.0))),
    "tf2_msgs/msg/TFMessage": (Transforms, Draw.transforms),
    "visualization_msgs/msg/MarkerArray": (Markers, Draw.markers),
}


def flat(value: Any) -> Iterator[Any]:
    """All that a message consists of, one after another, however its parts are put together."""
    if isinstance(value, Header):
        yield from (*divmod(value.stamp, NANO), value.frame)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            if field.name[0].islower():  # else a constant of the type
                yield from flat(getattr(value, field.name))
    elif isinstance(value, list | np.ndarray):
        for each in value:
            yield from flat(each)
    else:
        yield value


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_what_is_written_and_read_is_what_rosbags_reads_and_writes(name: str) -> None:
    kind, make = CASES[name]
    draw = Draw()
    for number in range(COUNT):
        message = make(draw)
        theirs = STORE.deserialize_cdr(message.serialize(), name)
        assert list(flat(theirs)) == list(flat(message))
        payload = bytes(STORE.serialize_cdr(theirs, name, little_endian=bool(number % 4)))
        assert decode(kind, payload) == message


@pytest.mark.parametrize("name", CASES)
def test_damaged_payloads_are_refused(name):
    kind, make = CASES[name]
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
