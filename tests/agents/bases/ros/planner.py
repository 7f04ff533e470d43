"""A planner as ROS 2 has it: drives one robot straight at its goal, and heeds no other.

Runs in the environment of `turtle.py`: `planner.py NAMESPACE X Y OFFSET`. The goal (m) is that of the
point OFFSET (m) ahead of the axle. It subscribes to pose, and publishes cmd_vel_desired ten times a second.
"""

import math
import sys

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.node import Node

SPEED = 0.12  # m/s


class Planner(Node):
    def __init__(self, namespace, goal, offset):
        super().__init__("planner", namespace=namespace)
        self.goal, self.offset, self.pose = goal, offset, None
        self.wish = self.create_publisher(Twist, "cmd_vel_desired", 10)
        self.create_subscription(PoseStamped, "pose", self.on_pose, 10)
        self.create_timer(0.1, self.on_time)

    def on_pose(self, message):
        self.pose = message.pose

    def on_time(self):
        if self.pose is None:
            return
        yaw = 2.0 * math.atan2(self.pose.orientation.z, self.pose.orientation.w)
        dx = self.goal[0] - self.pose.position.x - self.offset * math.cos(yaw)
        dy = self.goal[1] - self.pose.position.y - self.offset * math.sin(yaw)
        scale = min(SPEED / max(math.hypot(dx, dy), 1e-9), 1.0)
        twist = Twist()
        twist.linear.x = scale * (math.cos(yaw) * dx + math.sin(yaw) * dy)
        twist.angular.z = scale * (math.cos(yaw) * dy - math.sin(yaw) * dx) / self.offset
        self.wish.publish(twist)


def main():
    namespace, x, y, offset = sys.argv[1:]
    rclpy.init()
    rclpy.spin(Planner(namespace, (float(x), float(y)), float(offset)))


main()
