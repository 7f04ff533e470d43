"""`python -m tests.benchmarks.machine.outside`: private memory of robots' processes whose bases are outside.

Router, world and robots are real processes on zenoh; this one plays bases and localisation, for some
seconds in real time.
"""

from __future__ import annotations

import random
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

from deploy.library.load import load
from protocol.bus.bus import Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.scenario.file import write_toml
from protocol.scenario.model import Scenario
from tests.agents.bases.wheels import STEP, Wheels

SECONDS, ROBOTS = 15.0, 6
ASKED = 60.0  # MB


def play(scenario: Scenario, endpoint: str, seconds: float) -> None:
    """Be all bases for a while."""
    bus = ZenohBus(Connection(connect=(endpoint,)))
    wheels = {robot: Wheels(scenario, robot, random.Random(robot)) for robot in scenario.ids}
    tells = {
        (robot, what): bus.foreign(f"bot{robot}/{what}") for robot in wheels for what in ("odom", "pose")
    }
    bus.subscribe(*[f"bot{robot}/cmd_vel" for robot in wheels])
    begun, step = time.monotonic(), 0
    while (now := time.monotonic() - begun) < seconds:
        while (event := bus.receive(0.0)) is not None:
            if isinstance(event, Sample):
                wheels[int(event.key.partition("/")[0][3:])].hear(event.payload, now)
        while step * STEP <= now:
            step += 1
            for robot, each in wheels.items():
                each.roll(step * STEP)
                if step % 4 == 0:
                    tells[robot, "odom"](each.odometry(step * STEP).serialize())
                if step % 10 == 0:
                    tells[robot, "pose"](each.pose(step * STEP).serialize())
        time.sleep(0.002)
    bus.close()


def main() -> int:
    """Exit status 1 if a process takes more than is asked."""
    settings = ["world.plant=external", "time.step=0.1", "time.endless=true", "sensing.noise=0.003"]
    scenario = load(f"turtlebots-{ROBOTS}", [*settings, "sensing.noise_bound=0.006"], 1)
    disknav = [sys.executable, "-m", "disknav"]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "yard.toml")
        file.write_text(write_toml(scenario))
        router = subprocess.Popen([*disknav, "node", "router"], stderr=subprocess.PIPE, text=True)
        processes = [router]
        try:
            assert router.stderr is not None
            found = re.search(r"listening on (\S+)", router.stderr.readline())
            assert found is not None
            place = ["--run", "yard", "--router", found[1]]
            world = [*disknav, "node", "world", str(file), *place]
            processes.append(subprocess.Popen(world, stdout=subprocess.DEVNULL))
            robots = [
                subprocess.Popen([*disknav, "node", "robot", str(robot), *place, "--base", "ros2"])
                for robot in scenario.ids
            ]
            processes += robots
            play(scenario, found[1], SECONDS)
            taken = [psutil.Process(robot.pid).memory_full_info().uss / 1e6 for robot in robots]
        finally:
            for process in processes:
                process.terminate()
            for process in processes:
                process.wait(20.0)
    print(f"private memory of {ROBOTS} robots' processes, MB: {', '.join(f'{each:.1f}' for each in taken)}")
    print(f"asked: less than {ASKED:g}")
    return int(max(taken) >= ASKED)


if __name__ == "__main__":
    sys.exit(main())
