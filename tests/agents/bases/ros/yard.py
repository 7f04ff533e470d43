"""Fleets whose bases are processes of others, which note where they really are."""

import math
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import combinations
from pathlib import Path

from deploy.library.load import load
from deploy.run.options import fresh_run_name
from protocol.scenario.file import parse_document, read_document, write_toml
from tests.deploy.processes.ports import free_ports
from tests.until import until

HERE = Path(__file__).parent
NOISE = 0.008  # m, of poses
START = 150.0  # s that a dozen processes may take to start on a busy machine
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


class Yard:
    """Processes of a fleet, each with its output in a file, and where its bases say that they really are."""

    def __init__(self, folder: Path, scenario) -> None:
        self.folder, self.scenario = folder, scenario
        self.offset = scenario.body_of(1).offset
        self.starts = {spec.id: spec.start for spec in scenario.robots}
        self.goals = {spec.id: spec.goal for spec in scenario.robots}
        self.run, self.endpoint = fresh_run_name(), f"tcp/127.0.0.1:{free_ports(1)[0]}"
        self.processes: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str, *command: object, **options: object) -> None:
        output = (self.folder / name).open("wb")
        self.processes[name] = subprocess.Popen(
            [str(part) for part in command], stdout=output, stderr=subprocess.STDOUT, **options
        )

    def output(self, name: str) -> str:
        return (self.folder / name).read_text(errors="replace")

    def signal(self, name: str, number: signal.Signals) -> None:
        self.processes[name].send_signal(number)

    def end(self) -> None:
        for process in self.processes.values():
            process.send_signal(signal.SIGCONT)
            process.terminate()
        for process in self.processes.values():
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def axle(self, robot: int) -> tuple[float, float, float]:
        """Where the middle of a robot's axle starts, m, and which way it faces, rad."""
        spec = self.scenario.spec(robot)
        x = spec.start[0] - self.offset * math.cos(spec.heading)
        return x, spec.start[1] - self.offset * math.sin(spec.heading), spec.heading

    def truth(self, robot: int) -> list[tuple[float, float, float]]:
        """Time, and where the control point was, of everything so far."""
        rows = []
        for line in (self.folder / f"truth-{robot}").read_text().splitlines()[:-1]:
            now, x, y, yaw = map(float, line.split())
            rows.append((now, x + self.offset * math.cos(yaw), y + self.offset * math.sin(yaw)))
        return rows

    def place(self, robot: int) -> Vector:
        rows = self.truth(robot)
        return rows[-1][1:] if rows else self.starts[robot]

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
        alive = [robot for robot in ids if self.processes[f"base-{robot}"].poll() is None]
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

    def arrived(self) -> bool:
        return all(self.way(robot, goal) < 0.05 for robot, goal in self.goals.items())


def nearest(one: list[tuple[float, float, float]], other: list[tuple[float, float, float]]) -> float:
    """Smallest distance between two paths at the same time, each held until its next entry, m."""
    smallest, n = math.inf, 0
    for now, x, y in one:
        while n + 1 < len(other) and other[n + 1][0] <= now:
            n += 1
        smallest = min(smallest, math.hypot(x - other[n][1], y - other[n][2]))
    return smallest


@contextmanager
def yard(
    folder: Path, start_bases: Callable[[Yard], None], count: int = 6, settings: Iterable[str] = ()
) -> Iterator[Yard]:
    """A router, what `start_bases` starts, a world, and a process for each robot."""
    (folder / "yard.toml").write_text(write_toml(load(f"turtlebots-{count}", [*SETTINGS, *settings], 1)))
    scenario = parse_document(read_document(folder / "yard.toml"))
    result = Yard(folder, scenario)
    with ExitStack() as stack:
        stack.callback(result.end)
        result.start("router", *result.disknav("node", "router", "--listen", result.endpoint))
        until(lambda: "listening on" in result.output("router"), 30.0, "no router")
        start_bases(result)
        run = ("--run", result.run, "--router", result.endpoint)
        result.start("world", *result.disknav("node", "world", folder / "yard.toml", *run))
        for robot in scenario.ids:
            base = ("--base", "ros2", "--namespace", f"/bot{robot}")
            result.start(f"robot-{robot}", *result.disknav("node", "robot", robot, *run, *base))
        until(lambda: all((folder / f"truth-{robot}").exists() for robot in scenario.ids), START, "no bases")
        yield result
