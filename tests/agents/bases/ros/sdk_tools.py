"""What a person has at hand, on zenoh-ros2-sdk: `sdk_tools.py PORT`.

Every line of standard output is a topic and what was heard on it. Lines of standard input: `topics`;
`stop ROBOT 0|1`; `goal ROBOT X Y`.
"""

import json
import os
import sys

from sdk_types import T, described
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber
from zenoh_ros2_sdk.discovery import get_topic_names_and_types

THERE = {"router_ip": "127.0.0.1", "router_port": int(sys.argv[1]), "domain_id": 0}


def say(topic, what):
    os.write(1, f"{json.dumps([topic, what])}\n".encode())  # at once: callbacks come on several threads


def on_tf(message):
    for each in message.transforms:
        moved = each.transform.translation
        say("/tf", [each.header.frame_id, each.child_frame_id, moved.x, moved.y])


def on_markers(message):
    drawn = {each.ns: (each.type, len(each.points), each.pose.position) for each in message.markers}
    say("markers", {name: [kind, points, at.x, at.y] for name, (kind, points, at) in drawn.items()})


def on_odometry(message):
    place = message.pose.pose.position
    say("odom", [message.child_frame_id, place.x, place.y, float(message.pose.covariance[0])])


def main():
    listened = (
        ("/tf", "tf2_msgs/msg/TFMessage", on_tf),
        ("/bot1/disknav/markers", "visualization_msgs/msg/MarkerArray", on_markers),
        ("/bot1/disknav/odom", "nav_msgs/msg/Odometry", on_odometry),
    )
    kept = [
        ROS2Subscriber(topic, callback=take, **described(kind), **THERE) for topic, kind, take in listened
    ]
    stops, goals = (
        {n: ROS2Publisher(f"/bot{n}/{topic}", **described(kind), **THERE) for n in (1, 2)}
        for topic, kind in (
            ("disknav/stop", "std_msgs/msg/Bool"),
            ("goal_pose", "geometry_msgs/msg/PoseStamped"),
        )
    )
    say("ready", len(kept))
    for line in sys.stdin:
        what, *words = line.split()
        if what == "topics":
            here = {key: value for key, value in THERE.items() if key != "domain_id"}
            say("topics", dict(get_topic_names_and_types(0, timeout=2.0, **here)))
        elif what == "stop":
            stops[int(words[0])].publish(data=words[1] == "1")
        else:
            x, y = map(float, words[1:])
            pose = T["geometry_msgs/msg/Pose"](
                T["geometry_msgs/msg/Point"](x, y, 0.0), T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            )
            header = T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](0, 0), "map")
            goals[int(words[0])].publish(header=header, pose=pose)


main()
