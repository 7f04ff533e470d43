"""Does what zenoh-bridge-ros2dds does, for four topics of a few robots: CDR from DDS to zenoh and back.

Runs in the environment of `turtle.py`: `bridge.py ENDPOINT NAMESPACE...`. A topic is `/<namespace>/<topic>`,
a key of zenoh `<namespace>/<topic>`.
"""

import sys

import rclpy
import zenoh
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry


def main():
    endpoint, *namespaces = sys.argv[1:]
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    session, subscribers = zenoh.open(config), []
    rclpy.init()
    node = rclpy.create_node("bridge")
    for namespace in namespaces:
        for topic, kind in (("odom", Odometry), ("pose", PoseStamped), ("cmd_vel_desired", Twist)):
            publisher = session.declare_publisher(f"{namespace}/{topic}")
            node.create_subscription(kind, f"/{namespace}/{topic}", publisher.put, 10, raw=True)
        velocity = node.create_publisher(Twist, f"/{namespace}/cmd_vel", 10)

        def forward(sample, velocity=velocity):
            velocity.publish(sample.payload.to_bytes())

        subscribers.append(session.declare_subscriber(f"{namespace}/cmd_vel", forward))
    print("bridged", flush=True)
    rclpy.spin(node)


main()
