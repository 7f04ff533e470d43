"""A robot whose base, localisation and planner are one node on zenoh-ros2-sdk.

`sdk_robot.py PORT NAMESPACE X Y YAW TRUTH [GOAL_X GOAL_Y OFFSET]`. Two wheels, integrated; with a goal (m),
that of the point OFFSET (m) ahead of the axle, it wishes to drive straight at it. TRUTH is as `turtle.py`
writes it.
"""

import math
import sys
import time
from pathlib import Path

import numpy as np
from sdk_types import T, described
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber

TIMEOUT, FASTEST, SPEED = 0.25, 0.66, 0.12  # s, m/s^2 of a wheel, m/s
TRACK = 0.160  # m


class Robot:
    def __init__(self, port, namespace, x, y, yaw, truth, goal, offset):
        self.x, self.y, self.yaw, self.goal, self.offset = x, y, yaw, goal, offset
        self.ox = self.oy = self.oyaw = 0.0
        self.speeds, self.aims, self.heard = [0.0, 0.0], (0.0, 0.0), -math.inf
        self.truth = Path(truth).open("w")  # noqa: SIM115
        there = {"router_ip": "127.0.0.1", "router_port": port, "domain_id": 0, "namespace": namespace}
        ROS2Subscriber(
            f"{namespace}/cmd_vel", callback=self.hear, **described("geometry_msgs/msg/Twist"), **there
        )
        self.odom, self.pose, self.wish = (
            ROS2Publisher(f"{namespace}/{topic}", **described(kind), **there)
            for topic, kind in (
                ("odom", "nav_msgs/msg/Odometry"),
                ("pose", "geometry_msgs/msg/PoseStamped"),
                ("cmd_vel_desired", "geometry_msgs/msg/Twist"),
            )
        )

    def hear(self, twist):
        across = 0.5 * TRACK * twist.angular.z
        self.aims, self.heard = (twist.linear.x - across, twist.linear.x + across), time.monotonic()

    def roll(self, now, passed):
        aims = self.aims if now - self.heard < TIMEOUT else (0.0, 0.0)
        for n, aim in enumerate(aims):
            most = FASTEST * passed
            self.speeds[n] += max(-most, min(most, aim - self.speeds[n]))
        ahead, turn = 0.5 * sum(self.speeds) * passed, (self.speeds[1] - self.speeds[0]) / TRACK * passed
        for name, yaw in (("", self.yaw), ("o", self.oyaw)):
            for axis, part in (("x", math.cos), ("y", math.sin)):
                setattr(self, name + axis, getattr(self, name + axis) + ahead * part(yaw + 0.5 * turn))
            setattr(self, f"{name}yaw", yaw + turn)
        self.truth.write(f"{now:.6f} {self.x:.6f} {self.y:.6f} {self.yaw:.6f}\n")
        self.truth.flush()

    def speak(self, rounds):
        vector, zeros = T["geometry_msgs/msg/Vector3"], np.zeros(36)
        ahead, turn = 0.5 * sum(self.speeds), (self.speeds[1] - self.speeds[0]) / TRACK
        twist = T["geometry_msgs/msg/Twist"](vector(ahead, 0.0, 0.0), vector(0.0, 0.0, turn))
        located = T["geometry_msgs/msg/PoseWithCovariance"](posed(self.ox, self.oy, self.oyaw), zeros)
        moving = T["geometry_msgs/msg/TwistWithCovariance"](twist, zeros)
        self.odom.publish(header=stamped("odom"), child_frame_id="base_link", pose=located, twist=moving)
        if rounds % 3 == 0:
            self.pose.publish(header=stamped("map"), pose=posed(self.x, self.y, self.yaw))
        if rounds % 5 == 0 and self.goal is not None:
            dx = self.goal[0] - self.x - self.offset * math.cos(self.yaw)
            dy = self.goal[1] - self.y - self.offset * math.sin(self.yaw)
            scale = min(SPEED / max(math.hypot(dx, dy), 1e-9), 1.0)
            ahead = scale * (math.cos(self.yaw) * dx + math.sin(self.yaw) * dy)
            aside = scale * (math.cos(self.yaw) * dy - math.sin(self.yaw) * dx)
            self.wish.publish(linear=vector(ahead, 0.0, 0.0), angular=vector(0.0, 0.0, aside / self.offset))


def stamped(frame):
    seconds, nanoseconds = divmod(time.time_ns(), 10**9)
    return T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](seconds, nanoseconds), frame)


def posed(x, y, yaw):
    turned = T["geometry_msgs/msg/Quaternion"](0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))
    return T["geometry_msgs/msg/Pose"](T["geometry_msgs/msg/Point"](x, y, 0.0), turned)


def main():
    port, namespace, *place, truth = sys.argv[1:7]
    *goal, offset = map(float, sys.argv[7:]) if len(sys.argv) > 7 else (0.0,)
    robot = Robot(int(port), namespace, *map(float, place), truth, goal or None, offset)
    rounds, last = 0, time.monotonic()
    while True:
        now = time.monotonic()
        robot.roll(now, min(now - last, 0.1))
        last = now
        robot.speak(rounds)
        rounds += 1
        time.sleep(max(0.0, 0.02 - (time.monotonic() - now)))


main()
