"""The ROS 2 messages that a robot reads or writes, as `geometry_msgs`, `nav_msgs`, `std_msgs`, `tf2_msgs` and
`visualization_msgs` define them.

CDR knows no bounds between a message and those in it, so three doubles in a row are a vector. SI units; a
quaternion is (x, y, z, w).
"""

import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeVar, cast

from pycdr2 import IdlStruct
from pycdr2._support import Buffer  # the only one that returns the length of a message
from pycdr2.types import array, float32, float64, int32, uint8, uint32

from protocol.errors import MessageError

NANO: Final = 1_000_000_000
_PADDING: Final = 3  # most bytes after a message: some writers pad the last word

M = TypeVar("M", bound=IdlStruct)

if TYPE_CHECKING:  # which has no arrays of fixed size
    Vector3 = list[float]
    Quaternion = list[float]
    Covariance = list[float]
    Color = list[float]
    sequence = list
else:
    Vector3, Quaternion, Covariance = array[float64, 3], array[float64, 4], array[float64, 36]
    Color = array[float32, 4]
    from pycdr2.types import sequence


@dataclass
class Header(IdlStruct):
    """`std_msgs/msg/Header`: the time and the frame of some data."""

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


@dataclass
class Flag(IdlStruct):
    """`std_msgs/msg/Bool`."""

    data: bool


@dataclass
class Transform(IdlStruct):
    """`geometry_msgs/msg/TransformStamped`: pose of the frame `child` in that of the header."""

    header: Header
    child: str
    translation: Vector3
    rotation: Quaternion


@dataclass
class Transforms(IdlStruct):
    """`tf2_msgs/msg/TFMessage`."""

    transforms: sequence[Transform]


@dataclass
class Marker(IdlStruct):
    """`visualization_msgs/msg/Marker`; fields for textures, texts and meshes stay empty."""

    header: Header
    namespace: str
    id: int32
    type: int32  # 2 sphere, 3 cylinder, 5 list of lines
    action: int32  # 0 adds or replaces it
    pose: Pose
    scale: Vector3
    color: Color
    lifetime_sec: int32
    lifetime_nanosec: uint32
    frame_locked: bool
    points: sequence[Vector3] = field(default_factory=list)
    colors: sequence[uint32] = field(default_factory=list)
    texture_resource: str = ""
    texture_header: Header = field(default_factory=lambda: Header(0, 0, ""))
    texture_format: str = ""
    texture_data: sequence[uint8] = field(default_factory=list)
    uv_coordinates: sequence[uint32] = field(default_factory=list)
    text: str = ""
    mesh_resource: str = ""
    mesh_filename: str = ""
    mesh_data: sequence[uint8] = field(default_factory=list)
    mesh_use_embedded_materials: bool = False


@dataclass
class Markers(IdlStruct):
    """`visualization_msgs/msg/MarkerArray`."""

    markers: sequence[Marker]


def header_at(stamp: int, frame: str) -> Header:
    """The header of a time, ns."""
    return Header(*divmod(stamp, NANO), frame)


def decode(kind: type[M], payload: bytes) -> M:
    """Read a message; raises MessageError for invalid CDR, a wrong length, or text that is not UTF-8."""
    if len(payload) < 4 or payload[0] != 0 or payload[1] not in (0, 1):
        raise MessageError("shape", "no CDR: the first two bytes are neither 0 0 nor 0 1")
    buffer = Buffer(payload, align_offset=4)
    try:
        message = kind.deserialize(cast(bytes, buffer))  # which it accepts, too
    except (struct.error, ValueError) as error:
        raise MessageError("shape", f"no {kind.__name__} in CDR: {error}") from None
    if len(payload) - buffer.tell() > _PADDING:
        text = f"no {kind.__name__} in CDR: {len(payload)} bytes, of which it would have {buffer.tell()}"
        raise MessageError("shape", text)
    return message
