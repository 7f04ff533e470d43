"""The four ROS 2 messages of a base on wheels, as `geometry_msgs` and `nav_msgs` define them: Twist and
TwistStamped are written for it, PoseStamped and Odometry are read.

CDR knows no bounds between a message and those in it, so three doubles in a row are a vector. SI units; a
quaternion is (x, y, z, w).
"""

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

from pycdr2 import IdlStruct
from pycdr2.types import array, float64, int32, uint32

from protocol.errors import MessageError

NANO: Final = 1_000_000_000

M = TypeVar("M", bound=IdlStruct)

if TYPE_CHECKING:  # which knows nothing of arrays of a size
    Vector3 = list[float]
    Quaternion = list[float]
    Covariance = list[float]
else:
    Vector3, Quaternion, Covariance = array[float64, 3], array[float64, 4], array[float64, 36]


@dataclass
class Header(IdlStruct):
    """`std_msgs/msg/Header`: when something was true, and in which frame."""

    sec: int32
    nanosec: uint32
    frame: str

    @property
    def stamp(self) -> int:
        """The time, ns."""
        return int(self.sec) * NANO + int(self.nanosec)


@dataclass
class Velocity(IdlStruct):
    """`geometry_msgs/msg/Twist`: m/s and rad/s."""

    linear: Vector3
    angular: Vector3


@dataclass
class Pose(IdlStruct):
    """`geometry_msgs/msg/Pose`: m, and a quaternion."""

    position: Vector3
    orientation: Quaternion


@dataclass
class StampedVelocity(IdlStruct):
    """`geometry_msgs/msg/TwistStamped`."""

    header: Header
    velocity: Velocity


@dataclass
class StampedPose(IdlStruct):
    """`geometry_msgs/msg/PoseStamped`."""

    header: Header
    pose: Pose


@dataclass
class Odometry(IdlStruct):
    """`nav_msgs/msg/Odometry`: the pose in the frame of the header, the velocity in the frame `child`."""

    header: Header
    child: str
    pose: Pose
    pose_covariance: Covariance
    velocity: Velocity
    velocity_covariance: Covariance


def header_at(stamp: int, frame: str) -> Header:
    """The header of a time, ns."""
    return Header(*divmod(stamp, NANO), frame)


def decode(kind: type[M], payload: bytes) -> M:
    """Read a message.

    Raises:
        MessageError: the payload is no CDR, too short, or has a text that is no UTF-8.
    """
    if len(payload) < 4 or payload[0] != 0 or payload[1] not in (0, 1):
        raise MessageError("shape", "no CDR: the first two bytes are neither 0 0 nor 0 1")
    try:
        return kind.deserialize(payload)
    except (struct.error, ValueError) as error:
        raise MessageError("shape", f"no {kind.__name__} in CDR: {error}") from None
