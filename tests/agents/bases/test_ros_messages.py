"""ROS 2 messages against a second implementation, rosbags', whatever the numbers and the names."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
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

STORE = get_typestore(Stores.ROS2_JAZZY)
numbers = st.floats(allow_nan=False, allow_infinity=False)
texts = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20)
int32 = st.integers(-(2**31), 2**31 - 1)


def array(count: int, of: st.SearchStrategy[float] = numbers) -> st.SearchStrategy[list[float]]:
    return st.lists(of, min_size=count, max_size=count)


headers = st.builds(header_at, st.integers(0, 2**31 * NANO - 1), texts)
velocities = st.builds(Velocity, array(3), array(3))
poses = st.builds(Pose, array(3), array(4))
transforms = st.lists(st.builds(Transform, headers, texts, array(3), array(4)), max_size=2)
colors, points = array(4, st.floats(0.0, 1.0, width=32)), st.lists(array(3), max_size=3)
looks = poses, array(3), colors, int32, st.just(7), st.booleans(), points
marked = headers, texts, int32, int32, int32, *looks
CASES: dict[str, st.SearchStrategy[Any]] = {
    "geometry_msgs/msg/Twist": velocities,
    "geometry_msgs/msg/TwistStamped": st.builds(StampedVelocity, headers, velocities),
    "geometry_msgs/msg/PoseStamped": st.builds(StampedPose, headers, poses),
    "nav_msgs/msg/Odometry": st.builds(Odometry, headers, texts, poses, array(36), velocities, array(36)),
    "std_msgs/msg/Bool": st.builds(Flag, st.booleans()),
    "tf2_msgs/msg/TFMessage": st.builds(Transforms, transforms),
    "visualization_msgs/msg/MarkerArray": st.builds(
        Markers, st.lists(st.builds(Marker, *marked), max_size=2)
    ),
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
@given(st.data(), st.booleans())
@settings(max_examples=100)
def test_what_is_written_and_read_is_what_rosbags_reads_and_writes(
    name: str, data: st.DataObject, little: bool
) -> None:
    message = data.draw(CASES[name])
    theirs = STORE.deserialize_cdr(message.serialize(), name)
    assert list(flat(theirs)) == list(flat(message))
    assert decode(type(message), bytes(STORE.serialize_cdr(theirs, name, little_endian=little))) == message


@pytest.mark.parametrize("name", CASES)
@given(st.data())
@settings(max_examples=3)
def test_damaged_payloads_are_refused(name: str, data: st.DataObject) -> None:
    message = data.draw(CASES[name])
    kind, payload = type(message), message.serialize()
    for length in range(len(payload)):
        with pytest.raises(MessageError):
            decode(kind, payload[:length])
    for head in (b"\1\1", b"\0\2"):
        with pytest.raises(MessageError, match="no CDR"):
            decode(kind, head + payload[2:])
    decode(kind, payload + bytes(3))  # which some fill the last word with
    with pytest.raises(MessageError, match=f"{len(payload) + 4} bytes, of which"):
        decode(kind, payload + bytes(4))
    with pytest.raises(MessageError, match="utf-8"):
        decode(Header, Header(0, 0, "é").serialize().replace("é".encode(), b"\xff\xff"))
