"""The base's side of its ROS 2 messages: reads velocities, writes odometry and poses."""

from __future__ import annotations

from agents.bases.cdr import CdrReader, CdrWriter
from agents.bases.ros_messages import (
    Odometry,
    Pose,
    StampedPose,
    StampedVelocity,
    Velocity,
    read_header,
    read_velocity,
    write_header,
    write_velocity,
)


def decode_twist(payload: bytes) -> Velocity:
    """Read a Twist; raises MessageError."""
    return read_velocity(CdrReader(payload))


def decode_twist_stamped(payload: bytes) -> StampedVelocity:
    """Read a TwistStamped."""
    reader = CdrReader(payload)
    return StampedVelocity(read_header(reader), read_velocity(reader))


def encode_pose(message: StampedPose) -> bytes:
    """CDR of a PoseStamped."""
    writer = CdrWriter()
    write_header(writer, message.header)
    _write_pose(writer, message.pose)
    return writer.payload


def encode_odometry(message: Odometry) -> bytes:
    """CDR of an Odometry."""
    writer = CdrWriter()
    write_header(writer, message.header)
    writer.text(message.child)
    _write_pose(writer, message.pose)
    writer.doubles(message.pose_covariance)
    write_velocity(writer, message.velocity)
    writer.doubles(message.velocity_covariance)
    return writer.payload


def _write_pose(writer: CdrWriter, pose: Pose) -> None:
    writer.doubles((*pose.position, *pose.orientation))
