"""A fleet whose bases, localisations, planners and tools speak rmw_zenoh's dialect as others wrote it.

zenoh-ros2-sdk opens its sessions as rmw_zenoh does by default; it stands in for nodes on rmw_zenoh_cpp.
"""

import json
import math
import subprocess
import sys

import pytest

from agents.bases.dialects import BOOL, HASHES, MARKERS, ODOMETRY, STAMPED_POSE, TF, TWIST
from tests.agents.bases.crossing import CROSSING
from tests.agents.bases.ros.yard import HERE, START, Yard, yard
from tests.until import until

pytest.importorskip("zenoh_ros2_sdk")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.process,
    pytest.mark.alone,
    pytest.mark.long(45),
    pytest.mark.timeout(600),
]
SETTINGS = (*CROSSING, "base.dialect=rmw_zenoh", "base.tools=true", "control.law=external")


def port(fleet: Yard) -> str:
    return fleet.endpoint.rpartition(":")[2]


def sdk_nodes(fleet: Yard) -> None:
    """Robots that drive straight at their goals, and what a person has at hand."""
    for spec in fleet.scenario.robots:
        place = (f"/bot{spec.id}", *fleet.axle(spec.id), fleet.folder / f"truth-{spec.id}")
        aim = (*spec.goal, fleet.offset)
        fleet.start(f"base-{spec.id}", sys.executable, HERE / "sdk_robot.py", port(fleet), *place, *aim)
    fleet.start("tools", sys.executable, HERE / "sdk_tools.py", port(fleet), stdin=subprocess.PIPE)


def tell(fleet: Yard, *words: object) -> None:
    """A line for the tools."""
    tools = fleet.processes["tools"]
    tools.stdin.write((" ".join(map(str, words)) + "\n").encode())
    tools.stdin.flush()


def heard(fleet: Yard, topic: str) -> list:
    """What the tools have heard on a topic so far."""
    lines = fleet.output("tools").split("\n")[:-1]
    rows = [json.loads(line) for line in lines if line.startswith("[")]
    return [what for name, what in rows if name == topic]


def stands(fleet: Yard, robot: int) -> bool:
    """Whether a control point has not moved for 0.5 s."""
    rows = fleet.truth(robot)
    return max(math.dist(row[1:], rows[-1][1:]) for row in rows if row[0] > rows[-1][0] - 0.5) < 1e-4


def test_planners_arrive_behind_the_filter_are_seen_stopped_and_sent(tmp_path):
    with yard(tmp_path, sdk_nodes, 3, SETTINGS) as fleet:
        until(lambda: fleet.way(1, fleet.starts[1]) > 0.1, START, "robot 1 does not move")
        tell(fleet, "stop", 1, 1)
        until(lambda: stands(fleet, 1), 20.0, "robot 1 does not stand")
        tell(fleet, "stop", 1, 0)
        until(fleet.arrived, 120.0, "they do not arrive")
        assert fleet.gap() > 0.0

        child, x, y, variance = heard(fleet, "odom")[-1]
        assert child == "bot1/disk"
        assert math.dist((x, y), fleet.place(1)) <= math.sqrt(variance) + 0.01
        assert {"disk": 3, "goal": 2}.items() <= {
            n: row[0] for n, row in heard(fleet, "markers")[-1].items()
        }.items()
        assert {row["lines"][0] for row in heard(fleet, "markers") if "lines" in row} == {5}
        frames = {tuple(row[:2]) for row in heard(fleet, "/tf")}
        assert frames == {("map", f"bot{robot}/disk") for robot in fleet.goals}

        tell(fleet, "goal", 1, 0.3, 0.2)
        until(lambda: heard(fleet, "markers")[-1]["goal"][2:] == [0.3, 0.2], 20.0, "robot 1 has its old goal")
        assert_listed(fleet)


def assert_listed(fleet: Yard) -> None:
    """Every topic is found with its type, by what tokens say."""
    tell(fleet, "topics")
    until(lambda: bool(heard(fleet, "topics")), 20.0, "no topics")
    (topics,) = heard(fleet, "topics")
    kinds = {
        "cmd_vel": TWIST,
        "cmd_vel_desired": TWIST,
        "odom": ODOMETRY,
        "pose": STAMPED_POSE,
        "goal_pose": STAMPED_POSE,
        "disknav/stop": BOOL,
        "disknav/odom": ODOMETRY,
        "disknav/markers": MARKERS,
    }
    found = {f"/bot{robot}/{name}": [kind] for robot in fleet.scenario.ids for name, kind in kinds.items()}
    assert topics == found | {"/tf": [TF]}
    assert HASHES.keys() >= set(kinds.values())
