"""Six robots against a real ROS 2, process by process: coordinator and robots on zenoh, bases in rclpy.

Between them is an adapter that does what zenoh-bridge-ros2dds does. The bases note where they really are.
"""

from __future__ import annotations

import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import combinations
from pathlib import Path

import pytest

from deploy.library.load import load
from protocol.scenario.file import read_scenario, write_toml
from tests.agents.bases.crossing import CROSSING
from tests.agents.bases.ros import environment

# Odometry every 20 ms has to arrive in time, beside real physics.
pytestmark = [pytest.mark.slow, pytest.mark.process, pytest.mark.alone, pytest.mark.timeout(600)]
HERE = Path(__file__).parent
NOISE = 0.008  # m, of poses
SETTINGS = (
    "world.plant=external",
    "world.lease=0.8",
    "time.step=0.1",
    "time.tolerance=0.03",
    "time.endless=true",
    "sensing.noise=0.003",
    f"sensing.noise_bound={NOISE + 0.002}",
    "sensing.heading=0.03",
    "control.speed=0.2",
    "control.law=reciprocal",
    "base.latency=0.04",
    "base.patience=0.15",
    "base.age=0.12",
)
Vector = tuple[float, float]


class Processes:
    """Processes of a test, each with its output in a file."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.of: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str, *command: object, **options: object) -> None:
        output = (self._folder / name).open("wb")
        self.of[name] = subprocess.Popen(
            [str(part) for part in command], stdout=output, stderr=subprocess.STDOUT, **options
        )

    def output(self, name: str) -> str:
        return (self._folder / name).read_text(errors="replace")

    def signal(self, name: str, number: signal.Signals) -> None:
        self.of[name].send_signal(number)

    def end(self) -> None:
        for process in self.of.values():
            process.send_signal(signal.SIGCONT)
            process.terminate()
        for process in self.of.values():
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def until(condition: Callable[[], bool], seconds: float, what: str) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.05)


class Yard:
    """The fleet, and where its bases say that they really are."""

    def __init__(self, folder: Path, processes: Processes, scenario) -> None:
        self.folder, self.processes, self.scenario = folder, processes, scenario
        self.offset = scenario.body_of(1).offset
        self.endpoint = ""

    def truth(self, robot: int) -> list[tuple[float, float, float]]:
        """Time, and where the control point was, of everything so far."""
        rows = []
        for line in (self.folder / f"truth-{robot}").read_text().splitlines()[:-1]:
            now, x, y, yaw = map(float, line.split())
            rows.append((now, x + self.offset * math.cos(yaw), y + self.offset * math.sin(yaw)))
        return rows

    def place(self, robot: int) -> Vector:
        rows = self.truth(robot)
        return rows[-1][1:] if rows else self.scenario.spec(robot).start

    def way(self, robot: int, place: Vector) -> float:
        """How far a control point is from a place, m."""
        return math.dist(self.place(robot), place)

    def disknav(self, *arguments: object) -> list[object]:
        return [sys.executable, "-m", "disknav", *arguments]

    def order(self, *arguments: object) -> None:
        done = subprocess.run(
            [str(part) for part in self.disknav(*arguments, "--router", self.endpoint)],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr

    def speeds(self, begin: float, seconds: float) -> dict[int, float]:
        """Largest speed of each control point for so long from a time on, over 0.1 s, m/s."""
        end, ids = begin + seconds, self.scenario.ids
        alive = [robot for robot in ids if self.processes.of[f"base-{robot}"].poll() is None]
        until(lambda: all(self.truth(robot)[-1][0] >= end for robot in alive), 30.0, "a base is silent")
        fastest = {}
        for robot in ids:
            rows = [row for row in self.truth(robot) if begin <= row[0] <= end]
            pairs = [(a, b) for a, b in zip(rows, rows[5:], strict=False) if b[0] - a[0] < 0.3]
            fastest[robot] = max((math.dist(a[1:], b[1:]) / (b[0] - a[0]) for a, b in pairs), default=0.0)
        return fastest

    def gap(self) -> float:
        """Smallest gap between any two disks at any time so far, m."""
        paths = {robot: self.truth(robot) for robot in self.scenario.ids}
        smallest = math.inf
        for one, other in combinations(paths, 2):
            radii = self.scenario.spec(one).radius + self.scenario.spec(other).radius
            smallest = min(smallest, nearest(paths[one], paths[other]) - radii)
        return smallest

    def arrived(self, places: dict[int, Vector], within: float = 0.05) -> bool:
        return all(self.way(robot, place) < within for robot, place in places.items())


def nearest(one: list[tuple[float, float, float]], other: list[tuple[float, float, float]]) -> float:
    """Smallest distance between two paths at the same time, each held until its next entry, m."""
    smallest, n = math.inf, 0
    for now, x, y in one:
        while n + 1 < len(other) and other[n + 1][0] <= now:
            n += 1
        smallest = min(smallest, math.hypot(x - other[n][1], y - other[n][2]))
    return smallest


@contextmanager
def yard(folder: Path, count: int = 6, settings: Iterable[str] = ()) -> Iterator[Yard]:
    interpreter = environment.python()
    domain = 1 + os.getpid() % 100
    (folder / "yard.toml").write_text(write_toml(load(f"turtlebots-{count}", [*SETTINGS, *settings], 1)))
    scenario = read_scenario(folder / "yard.toml")
    processes = Processes(folder)
    with ExitStack() as stack:
        stack.callback(processes.end)
        result = Yard(folder, processes, scenario)
        processes.start("router", *result.disknav("node", "router"))
        listening = re.compile(r"listening on (\S+)")
        until(lambda: bool(listening.search(processes.output("router"))), 30.0, "no router")
        found = listening.search(processes.output("router"))
        assert found is not None
        result.endpoint = found[1]
        apart = {"env": environment.environment(domain)}
        for spec in scenario.robots:
            x = spec.start[0] - result.offset * math.cos(spec.heading)
            y = spec.start[1] - result.offset * math.sin(spec.heading)
            base = [HERE / "turtle.py", f"/bot{spec.id}", x, y, spec.heading, NOISE]
            processes.start(f"base-{spec.id}", interpreter, *base, folder / f"truth-{spec.id}", **apart)
            if scenario.control.law == "external":
                planner = [HERE / "planner.py", f"/bot{spec.id}", *spec.goal, result.offset]
                processes.start(f"planner-{spec.id}", interpreter, *planner, **apart)
        names = [f"bot{robot}" for robot in scenario.ids]
        processes.start("bridge", interpreter, HERE / "bridge.py", result.endpoint, *names, **apart)
        world = ("node", "world", folder / "yard.toml", "--run", "yard", "--router", result.endpoint)
        processes.start("world", *result.disknav(*world))
        for robot in scenario.ids:
            own = (
                "--run",
                "yard",
                "--router",
                result.endpoint,
                "--base",
                "ros2",
                "--namespace",
                f"/bot{robot}",
            )
            processes.start(f"robot-{robot}", *result.disknav("node", "robot", robot, *own))
        yield result


def stand_without_coordinator(fleet: Yard) -> None:
    """It is stopped for a while: everybody stands, each by itself."""
    body = fleet.scenario.body_of(1)
    stops = body.hold + body.lag + body.speed / body.acceleration  # s until a base left alone stands
    fleet.processes.signal("world", signal.SIGSTOP)
    quiet = fleet.speeds(time.monotonic() + fleet.scenario.time.step + stops, 0.9)
    fleet.processes.signal("world", signal.SIGCONT)
    assert max(quiet.values()) < 0.01, quiet


@pytest.mark.campaign
def test_six_robots_swap_and_survive_what_may_happen_to_bases_and_coordinator(tmp_path):
    with yard(tmp_path) as fleet:
        processes, scenario = fleet.processes, fleet.scenario
        starts = {spec.id: spec.start for spec in scenario.robots}
        goals = {spec.id: spec.goal for spec in scenario.robots}
        body = scenario.body_of(1)
        stops = body.hold + body.lag + body.speed / body.acceleration  # s until a base left alone stands

        until(lambda: all((tmp_path / f"truth-{r}").exists() for r in goals), 60.0, "no bases")
        until(lambda: max(map(fleet.way, goals, starts.values())) > 0.05, 60.0, "nobody moves")

        # a base hangs while others drive on: its robot stands, says so, and goes on
        processes.signal("base-2", signal.SIGSTOP)
        until(lambda: "no odometry" in processes.output("robot-2"), 10.0, "robot 2 does not notice")
        others = {robot: fleet.place(robot) for robot in goals if robot != 2}
        until(lambda: max(map(fleet.way, others, others.values())) > 0.2, 20.0, "all stand for robot 2")
        processes.signal("base-2", signal.SIGCONT)
        until(
            lambda: "are sound" in processes.output("robot-2").rpartition("no odometry")[2], 20.0, "2 is lost"
        )

        stand_without_coordinator(fleet)
        until(lambda: fleet.arrived(goals), 90.0, "they do not arrive")

        # on the way back one base dies: its robot stands for good, nobody touches it
        for robot in (2, 3, 4):
            fleet.order("fleet", "goal", "yard", robot, *starts[robot])
        until(lambda: fleet.way(3, goals[3]) > 0.15, 60.0, "robot 3 does not leave")
        processes.signal("base-3", signal.SIGKILL)
        until(
            lambda: processes.output("robot-3").rstrip().endswith("stands"), 10.0, "robot 3 does not notice"
        )
        passing = {robot: fleet.place(robot) for robot in (2, 4)}
        until(
            lambda: max(map(fleet.way, passing, passing.values())) > 0.1,
            30.0,
            "nobody passes robot 3",
        )

        # the emergency stop
        fleet.order("stop", "yard")
        quiet = fleet.speeds(time.monotonic() + scenario.time.step + stops, 0.9)
        assert max(quiet.values()) < 0.01, quiet
        assert fleet.gap() > 0.0
        print(f"smallest gap {1e3 * fleet.gap():.1f} mm")


@contextmanager
def planned(folder: Path, filter_: str) -> Iterator[Yard]:
    """Three robots whose planners heed no robot, once all bases speak."""
    with yard(folder, 3, [*CROSSING, "control.law=external", f"control.filter={filter_}"]) as fleet:
        robots = fleet.scenario.ids
        until(lambda: all((folder / f"truth-{robot}").exists() for robot in robots), 60.0, "no bases")
        until(lambda: all(map(fleet.truth, robots)), 60.0, "a base is silent")
        yield fleet


def test_planners_that_heed_no_robot_arrive_behind_the_filter_and_stand_without_a_coordinator(tmp_path):
    with planned(tmp_path, "separating-lines") as fleet:
        starts = {spec.id: spec.start for spec in fleet.scenario.robots}
        until(lambda: max(map(fleet.way, starts, starts.values())) > 0.1, 60.0, "nobody moves")
        stand_without_coordinator(fleet)
        until(
            lambda: fleet.arrived({r.id: r.goal for r in fleet.scenario.robots}), 120.0, "they do not arrive"
        )
        assert fleet.gap() > 0.0


@pytest.mark.campaign
def test_without_the_filter_they_touch(tmp_path):
    with planned(tmp_path, "none") as fleet:
        until(lambda: fleet.gap() < 0.0, 120.0, "they do not touch")
