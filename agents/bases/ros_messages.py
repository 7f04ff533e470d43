"""The four ROS 2 messages that a base on wheels speaks, as `geometry_msgs` and `nav_msgs` define them.

SI units. A quaternion is (x, y, z, w), a velocity three linear and three angular components.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from agents.bases.cdr import CdrReader, CdrWriter

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Covariance = tuple[float, ...]
NANO: Final = 1_000_000_000
UNKNOWN: Final[Covariance] = (0.0,) * 36  # covariances that say nothing


class Header(NamedTuple):
    """When something was true, ns, and in which frame."""

    stamp: int
    frame: str


class Velocity(NamedTuple):
    """`geometry_msgs/msg/Twist`: m/s and rad/s."""

    linear: Vector3
    angular: Vector3


class Pose(NamedTuple):
    """`geometry_msgs/msg/Pose`: m, and a quaternion."""

    position: Vector3
    orientation: Quaternion


class StampedVelocity(NamedTuple):
    """`geometry_msgs/msg/TwistStamped`."""

    header: Header
    velocity: Velocity


class StampedPose(NamedTuple):
    """`geometry_msgs/msg/PoseStamped`."""

    header: Header
    pose: Pose


class Odometry(NamedTuple):
    """`nav_msgs/msg/Odometry`: the pose in the frame of the header, the velocity in the frame `child`."""

    header: Header
    child: str
    pose: Pose
    velocity: Velocity
    pose_covariance: Covariance = UNKNOWN
    velocity_covariance: Covariance = UNKNOWN


def encode_twist(velocity: Velocity) -> bytes:
    """CDR of a Twist."""
    writer = CdrWriter()
    _write_velocity(writer, velocity)
    return writer.payload


def decode_twist(payload: bytes) -> Velocity:
    """Read a Twist; raises MessageError, as all of the following do."""
    return _velocity(CdrReader(payload))


def encode_twist_stamped(message: StampedVelocity) -> bytes:
    """CDR of a TwistStamped."""
    writer = CdrWriter()
    _write_header(writer, message.header)
    _write_velocity(writer, message.velocity)
    return writer.payload


def decode_twist_stamped(payload: bytes) -> StampedVelocity:
    """Read a TwistStamped."""
    reader = CdrReader(payload)
    return StampedVelocity(_header(reader), _velocity(reader))


def encode_pose(message: StampedPose) -> bytes:
    """CDR of a PoseStamped."""
    writer = CdrWriter()
    _write_header(writer, message.header)
    _write_pose(writer, message.pose)
    return writer.payload


def decode_pose(payload: bytes) -> StampedPose:
    """Read a PoseStamped."""
    reader = CdrReader(payload)
    return StampedPose(_header(reader), _pose(reader))


def encode_odometry(message: Odometry) -> bytes:
    """CDR of an Odometry."""
    writer = CdrWriter()
    _write_header(writer, message.header)
    writer.text(message.child)
    _write_pose(writer, message.pose)
    writer.doubles(message.pose_covariance)
    _write_velocity(writer, message.velocity)
    writer.doubles(message.velocity_covariance)
    return writer.payload


def decode_odometry(payload: bytes) -> Odometry:
    """Read an Odometry."""
    reader = CdrReader(payload)
    header, child, pose = _header(reader), reader.text(), _pose(reader)
    pose_covariance = reader.doubles(36)
    return Odometry(header, child, pose, _velocity(reader), pose_covariance, reader.doubles(36))


def _header(reader: CdrReader) -> Header:
    (seconds,) = reader.numbers("i", 4)
    (nanoseconds,) = reader.numbers("I", 4)
    return Header(int(seconds) * NANO + int(nanoseconds), reader.text())


def _write_header(writer: CdrWriter, header: Header) -> None:
    seconds, nanoseconds = divmod(header.stamp, NANO)
    writer.numbers("i", 4, (seconds,))
    writer.numbers("I", 4, (nanoseconds,))
    writer.text(header.frame)


def _pose(reader: CdrReader) -> Pose:
    x, y, z, qx, qy, qz, qw = reader.doubles(7)
    return Pose((x, y, z), (qx, qy, qz, qw))


def _write_pose(writer: CdrWriter, pose: Pose) -> None:
    writer.doubles((*pose.position, *pose.orientation))


def _velocity(reader: CdrReader) -> Velocity:
    vx, vy, vz, wx, wy, wz = reader.doubles(6)
    return Velocity((vx, vy, vz), (wx, wy, wz))


def _write_velocity(writer: CdrWriter, velocity: Velocity) -> None:
    writer.doubles((*velocity.linear, *velocity.angular))
