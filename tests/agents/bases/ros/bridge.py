"""Does what zenoh-bridge-ros2dds does, for four topics of a few robots: CDR from DDS to zenoh and back.

Runs in the environment of `turtle.py`: `bridge.py ENDPOINT NAMESPACE...`. A DDS topic is
`rt/<namespace>/<topic>`, a key of zenoh `<namespace>/<topic>`.
"""

import os
import sys
import time
from dataclasses import dataclass

import zenoh
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as t
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

double = t.float64
QOS = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))


def named(package, name):
    return f"{package}::msg::dds_::{name}_"


@dataclass
class Time(IdlStruct, typename=named("builtin_interfaces", "Time")):
    sec: t.int32
    nanosec: t.uint32


@dataclass
class Header(IdlStruct, typename=named("std_msgs", "Header")):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct, typename=named("geometry_msgs", "Vector3")):
    x: double
    y: double
    z: double


@dataclass
class Point(IdlStruct, typename=named("geometry_msgs", "Point")):
    x: double
    y: double
    z: double


@dataclass
class Quaternion(IdlStruct, typename=named("geometry_msgs", "Quaternion")):
    x: double
    y: double
    z: double
    w: double


@dataclass
class Pose(IdlStruct, typename=named("geometry_msgs", "Pose")):
    position: Point
    orientation: Quaternion


@dataclass
class Twist(IdlStruct, typename=named("geometry_msgs", "Twist")):
    linear: Vector3
    angular: Vector3


@dataclass
class PoseStamped(IdlStruct, typename=named("geometry_msgs", "PoseStamped")):
    header: Header
    pose: Pose


@dataclass
class PoseWithCovariance(IdlStruct, typename=named("geometry_msgs", "PoseWithCovariance")):
    pose: Pose
    covariance: t.array[double, 36]


@dataclass
class TwistWithCovariance(IdlStruct, typename=named("geometry_msgs", "TwistWithCovariance")):
    twist: Twist
    covariance: t.array[double, 36]


@dataclass
class Odometry(IdlStruct, typename=named("nav_msgs", "Odometry")):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


def main():
    endpoint, *namespaces = sys.argv[1:]
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    session, domain = zenoh.open(config), DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
    incoming, subscribers = [], []
    for namespace in namespaces:
        for topic, kind in (("odom", Odometry), ("pose", PoseStamped), ("cmd_vel_desired", Twist)):
            reader = DataReader(domain, Topic(domain, f"rt/{namespace}/{topic}", kind), qos=QOS)
            incoming.append((reader, session.declare_publisher(f"{namespace}/{topic}")))
        writer = DataWriter(domain, Topic(domain, f"rt/{namespace}/cmd_vel", Twist), qos=QOS)

        def forward(sample, writer=writer):
            writer.write(Twist.deserialize(sample.payload.to_bytes()))

        subscribers.append(session.declare_subscriber(f"{namespace}/cmd_vel", forward))
    print("bridged", flush=True)
    while True:
        for reader, publisher in incoming:
            for sample in reader.take(16):
                publisher.put(sample.serialize())
        time.sleep(0.004)


main()
