"""The four ROS 2 messages of a base on wheels, as `geometry_msgs` and `nav_msgs` define them: two are written
for it, two are read.

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
    write_velocity(writer, velocity)
    return writer.payload


def encode_twist_stamped(message: StampedVelocity) -> bytes:
    """CDR of a TwistStamped."""
    writer = CdrWriter()
    write_header(writer, message.header)
    write_velocity(writer, message.velocity)
    return writer.payload


def decode_pose(payload: bytes) -> StampedPose:
    """Read a PoseStamped."""
    reader = CdrReader(payload)
    return StampedPose(read_header(reader), _pose(reader))


def decode_odometry(payload: bytes) -> Odometry:
    """Read an Odometry."""
    reader = CdrReader(payload)
    header, child, pose = read_header(reader), reader.text(), _pose(reader)
    pose_covariance = reader.doubles(36)
    return Odometry(header, child, pose, read_velocity(reader), pose_covariance, reader.doubles(36))


def read_header(reader: CdrReader) -> Header:
    """Take a Header; raises MessageError, as all that read do."""
    (seconds,) = reader.numbers("i", 4)
    (nanoseconds,) = reader.numbers("I", 4)
    return Header(int(seconds) * NANO + int(nanoseconds), reader.text())


def write_header(writer: CdrWriter, header: Header) -> None:
    """Put a Header."""
    seconds, nanoseconds = divmod(header.stamp, NANO)
    writer.numbers("i", 4, (seconds,))
    writer.numbers("I", 4, (nanoseconds,))
    writer.text(header.frame)


def _pose(reader: CdrReader) -> Pose:
    x, y, z, qx, qy, qz, qw = reader.doubles(7)
    return Pose((x, y, z), (qx, qy, qz, qw))


def read_velocity(reader: CdrReader) -> Velocity:
    """Take a Twist."""
    vx, vy, vz, wx, wy, wz = reader.doubles(6)
    return Velocity((vx, vy, vz), (wx, wy, wz))


def write_velocity(writer: CdrWriter, velocity: Velocity) -> None:
    """Put a Twist."""
    writer.doubles((*velocity.linear, *velocity.angular))
