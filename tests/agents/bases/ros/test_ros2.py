"""Six robots against a real ROS 2, process by process: coordinator and robots on zenoh, bases in rclpy.

Between them is an adapter that does what zenoh-bridge-ros2dds does. The bases note where they really are.
"""

import os
import signal
import time

import pytest

from protocol.scenario.model import Scenario
from tests.agents.bases.crossing import CROSSING
from tests.agents.bases.ros import environment
from tests.agents.bases.ros.yard import HERE, NOISE, START, Yard, yard
from tests.until import until

# Odometry every 20 ms has to arrive in time, beside real physics.
pytestmark = [pytest.mark.slow, pytest.mark.process, pytest.mark.alone, pytest.mark.timeout(600)]


def turtles(fleet: Yard) -> None:
    """Bases of rclpy, with planners where the law is from outside, and the bridge."""
    interpreter, ids = environment.python(), fleet.scenario.ids
    apart = {"env": environment.environment(1 + os.getpid() % 100)}
    for spec in fleet.scenario.robots:
        place = (f"/bot{spec.id}", *fleet.axle(spec.id), NOISE, fleet.folder / f"truth-{spec.id}")
        aim = (*spec.goal, fleet.offset) if fleet.scenario.control.law == "external" else ()
        fleet.start(f"base-{spec.id}", interpreter, HERE / "turtle.py", *place, *aim, **apart)
    names = [f"bot{robot}" for robot in ids]
    fleet.start("bridge", interpreter, HERE / "bridge.py", fleet.endpoint, *names, **apart)


def stopping(scenario: Scenario) -> float:
    """Time in which a base that is left alone stands, s."""
    body, base = scenario.body_of(1), scenario.base_of(1)
    return body.hold + body.lag + base.lateness.age + body.speed / body.acceleration


def stand_without_coordinator(fleet: Yard) -> None:
    """The world is stopped for a while: every robot stands by itself."""
    stops = stopping(fleet.scenario)
    fleet.signal("world", signal.SIGSTOP)
    quiet = fleet.speeds(time.monotonic() + fleet.scenario.time.step + stops, 0.9)
    fleet.signal("world", signal.SIGCONT)
    assert max(quiet.values()) < 0.01, quiet


@pytest.mark.campaign
def test_six_robots_swap_and_survive_what_may_happen_to_bases_and_coordinator(tmp_path):
    with yard(tmp_path, turtles) as fleet:
        scenario, starts, goals = fleet.scenario, fleet.starts, fleet.goals
        until(lambda: max(map(fleet.way, goals, starts.values())) > 0.05, START, "no robot moves")

        # a base hangs while others drive on: its robot stands, says so, and goes on
        fleet.signal("base-2", signal.SIGSTOP)
        until(lambda: "no odometry" in fleet.output("robot-2"), 10.0, "robot 2 does not notice")
        others = {robot: fleet.place(robot) for robot in goals if robot != 2}
        until(lambda: max(map(fleet.way, others, others.values())) > 0.2, 20.0, "all stand for robot 2")
        fleet.signal("base-2", signal.SIGCONT)
        until(lambda: "are sound" in fleet.output("robot-2").rpartition("no odometry")[2], 20.0, "2 is lost")

        stand_without_coordinator(fleet)
        until(fleet.arrived, 90.0, "they do not arrive")

        # on the way back one base dies: its robot stands for good, and no robot touches it
        for robot in (2, 3, 4):
            fleet.order("fleet", "goal", fleet.run, robot, *starts[robot])
        until(lambda: fleet.way(3, goals[3]) > 0.15, 60.0, "robot 3 does not leave")
        fleet.signal("base-3", signal.SIGKILL)
        until(lambda: fleet.output("robot-3").rstrip().endswith("stands"), 10.0, "robot 3 does not notice")
        passing = {robot: fleet.place(robot) for robot in (2, 4)}
        until(lambda: max(map(fleet.way, passing, passing.values())) > 0.1, 30.0, "no robot passes robot 3")

        # the emergency stop
        fleet.order("stop", fleet.run)
        quiet = fleet.speeds(time.monotonic() + scenario.time.step + stopping(scenario), 0.9)
        assert max(quiet.values()) < 0.01, quiet
        assert fleet.gap() > 0.0
        print(f"smallest gap {1e3 * fleet.gap():.1f} mm")


def test_planners_that_heed_no_robot_arrive_behind_the_filter_and_stand_without_a_coordinator(tmp_path):
    with yard(tmp_path, turtles, 3, [*CROSSING, "control.law=external"]) as fleet:
        until(lambda: all(map(fleet.truth, fleet.starts)), START, "a base is silent")
        until(
            lambda: max(fleet.way(robot, place) for robot, place in fleet.starts.items()) > 0.1,
            START,
            "no robot moves",
        )
        stand_without_coordinator(fleet)
        until(fleet.arrived, 120.0, "they do not arrive")
        assert fleet.gap() > 0.0
