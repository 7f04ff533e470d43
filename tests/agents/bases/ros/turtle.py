"""A robot as ROS 2 has it, that knows nothing of this project: an rclpy node around MuJoCo.

Runs in an environment of its own, which has rclpy, mujoco and numpy and nothing else of what is used here:
`turtle.py NAMESPACE X Y YAW NOISE TRUTH [GOAL_X GOAL_Y OFFSET]`. It subscribes to cmd_vel and stops 0.25 s
after the last one; it publishes odom by its wheels' encoders, and pose with an error of up to NOISE (m). Each
line of TRUTH is a time (s, CLOCK_MONOTONIC) and where the axle's middle really is then, and which way it
faces. With a goal (m), that of the point OFFSET (m) ahead of the axle, it also wishes, by cmd_vel_desired, to
drive straight at it, and heeds no other robot.
"""

import math
import random
import sys
import time
from pathlib import Path

import mujoco
import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node

RADIUS, TRACK, FASTEST = 0.033, 0.160, 0.66
TIMEOUT, SPEED = 0.25, 0.12  # s, m/s that it wishes
BURGER = f"""
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom type="plane" size="20 20 1" friction="1 .005 .0001"/>
    <body name="base" pos="{{x}} {{y}} {RADIUS}" euler="0 0 {{yaw}}">
      <freejoint/>
      <geom type="cylinder" size=".1 .02" pos="0 0 .05" mass=".9"/>
      <geom type="sphere" size=".012" pos="-.07 0 -.0207" mass=".02" condim="1" priority="1"/>
      <geom type="sphere" size=".012" pos=".07 0 -.0207" mass=".02" condim="1" priority="1"/>
      <body pos="0 {TRACK / 2} 0">
        <joint name="left" axis="0 1 0" damping=".001"/>
        <geom type="cylinder" size="{RADIUS} .009" euler="90 0 0" mass=".05" friction="1 .005 .0001"/>
      </body>
      <body pos="0 {-TRACK / 2} 0">
        <joint name="right" axis="0 1 0" damping=".001"/>
        <geom type="cylinder" size="{RADIUS} .009" euler="90 0 0" mass=".05" friction="1 .005 .0001"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity joint="left" kv=".05" forcerange="-.2 .2"/>
    <velocity joint="right" kv=".05" forcerange="-.2 .2"/>
  </actuator>
</mujoco>
"""


class Turtle(Node):
    def __init__(self, namespace, x, y, yaw, noise, truth, goal, offset):
        super().__init__("turtle", namespace=namespace)
        degrees = math.degrees(yaw)
        self.model = mujoco.MjModel.from_xml_string(BURGER.format(x=x, y=y, yaw=degrees))
        self.data = mujoco.MjData(self.model)
        mujoco.mj_step(self.model, self.data, 200)
        self.noise, self.random = noise, random.Random(namespace)
        self.goal, self.offset = goal, offset
        self.truth = Path(truth).open("w")  # noqa: SIM115
        self.aims, self.told, self.heard = (0.0, 0.0), [0.0, 0.0], -math.inf
        self.x = self.y = self.yaw = 0.0
        self.angles = self.read()
        self.begun = self.steps = None
        self.odom = self.create_publisher(Odometry, "odom", 10)
        self.pose = self.create_publisher(PoseStamped, "pose", 10)
        self.wish = self.create_publisher(Twist, "cmd_vel_desired", 10)
        self.create_subscription(Twist, "cmd_vel", self.on_velocity, 10)
        self.create_timer(0.02, self.on_time)
        self.rounds = 0

    def read(self):
        return [float(self.data.joint(name).qpos[0]) for name in ("left", "right")]

    def on_velocity(self, message):
        across = 0.5 * TRACK * message.angular.z
        self.aims, self.heard = (message.linear.x - across, message.linear.x + across), time.monotonic()

    def on_time(self):
        now = time.monotonic()
        if self.begun is None:
            self.begun, self.steps = now, 0
        due = int((now - self.begun) / 0.002) - self.steps
        if due > 100:  # it was stopped: the motors were, too
            self.begun, self.steps, due = now, 0, 1
        if now - self.heard > TIMEOUT:
            self.aims = (0.0, 0.0)
        for _ in range(due):
            for n, aim in enumerate(self.aims):
                most = FASTEST * 0.002
                self.told[n] += max(-most, min(most, aim - self.told[n]))
                self.data.ctrl[n] = self.told[n] / RADIUS
            mujoco.mj_step(self.model, self.data)
        self.steps += due
        self.count()
        self.speak(now)

    def count(self):
        angles = self.read()
        left, right = (RADIUS * (new - old) for new, old in zip(angles, self.angles, strict=True))
        self.angles = angles
        turn = (right - left) / TRACK
        middle = self.yaw + 0.5 * turn
        self.x += 0.5 * (left + right) * math.cos(middle)
        self.y += 0.5 * (left + right) * math.sin(middle)
        self.yaw += turn

    def speak(self, now):
        stamp = self.get_clock().now().to_msg()
        body = self.data.body("base")
        x, y = body.xpos[0], body.xpos[1]
        yaw = math.atan2(body.xmat[3], body.xmat[0])
        self.truth.write(f"{now:.6f} {x:.6f} {y:.6f} {yaw:.6f}\n")
        self.truth.flush()
        message = Odometry()
        message.header.stamp, message.header.frame_id, message.child_frame_id = stamp, "odom", "base_link"
        message.pose.pose.position.x, message.pose.pose.position.y = self.x, self.y
        message.pose.pose.orientation.z = math.sin(0.5 * self.yaw)
        message.pose.pose.orientation.w = math.cos(0.5 * self.yaw)
        message.twist.twist.linear.x = 0.5 * sum(self.told)
        message.twist.twist.angular.z = (self.told[1] - self.told[0]) / TRACK
        self.odom.publish(message)
        self.rounds += 1
        if self.rounds % 3 == 0:
            size, angle = self.noise * self.random.random(), self.random.uniform(0.0, math.tau)
            pose = PoseStamped()
            pose.header.stamp, pose.header.frame_id = stamp, "map"
            pose.pose.position.x = float(x + size * math.cos(angle))
            pose.pose.position.y = float(y + size * math.sin(angle))
            pose.pose.orientation.z, pose.pose.orientation.w = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
            self.pose.publish(pose)
        if self.rounds % 5 == 0 and self.goal is not None:
            self.drive_at_goal(x, y, yaw)

    def drive_at_goal(self, x, y, yaw):
        dx = self.goal[0] - x - self.offset * math.cos(yaw)
        dy = self.goal[1] - y - self.offset * math.sin(yaw)
        scale = min(SPEED / max(math.hypot(dx, dy), 1e-9), 1.0)
        twist = Twist()
        twist.linear.x = float(scale * (math.cos(yaw) * dx + math.sin(yaw) * dy))
        twist.angular.z = float(scale * (math.cos(yaw) * dy - math.sin(yaw) * dx) / self.offset)
        self.wish.publish(twist)


def main():
    namespace, *place, noise, truth = sys.argv[1:7]
    *goal, offset = map(float, sys.argv[7:]) if len(sys.argv) > 7 else (0.0,)
    rclpy.init()
    rclpy.spin(Turtle(namespace, *map(float, place), float(noise), truth, goal or None, offset))


main()
