"""`law = "external"`: robots want what they are told, and the filter keeps them apart all the same."""

import json
import math
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
import zenoh

import disknav
from deploy.run.options import fresh_run_name
from protocol.scenario.file import write_toml
from tests.deploy.processes.ports import free_ports

CROSSING: dict[str, Any] = {
    "name": "crossing",
    "control": {"law": "external", "speed": 0.1},
    "time": {"limit": 30.0},
    "robots": [
        {"id": n + 1, "radius": 0.03, "start": [x, y], "goal": [-x, -y]}
        for n, (x, y) in enumerate([(0.2, 0.005), (-0.2, 0.0), (0.0, 0.2), (0.005, -0.2)])
    ],
}


def test_a_wish_moves_its_robot_and_counts_for_its_lifetime() -> None:
    settings = {"control.lifetime": 0.25, "time.step": 0.05}
    simulation = disknav.Simulation(disknav.build(CROSSING, settings))
    simulation.step()
    before = simulation.positions
    simulation.orders.wish(3, (0.0, -0.08))
    for _ in range(12):
        simulation.step()
    moved = simulation.positions - before
    assert moved[2] == pytest.approx((0.0, -0.08 * 0.05 * 6), abs=0.08 * 0.05 + 1e-9)
    assert np.abs(moved[[0, 1, 3]]).max() == 0.0


@pytest.mark.process
@pytest.mark.slow
def test_a_planner_drives_real_processes_by_key_with_no_more_than_zenoh(tmp_path: Path) -> None:
    """It hears the truth and says wishes, as docs/streams.md has them, straight through each other."""
    scenario = disknav.build(CROSSING, {"control.lifetime": 2.0, "time.limit": 5.0})
    (tmp_path / "crossing.toml").write_text(write_toml(scenario))
    page = (Path(__file__).parents[2] / "docs/streams.md").read_text()
    kind_of_wish = re.findall(r'"(wish/\d+)"', page)[0]
    run, endpoint = fresh_run_name(), f"tcp/127.0.0.1:{free_ports(1)[0]}"
    call = [sys.executable, "-m", "disknav", "run", "crossing.toml", "--speed", "2", "--quiet"]
    call += ["--run", run, "--listen", endpoint, "--json", "result.json"]
    fleet = subprocess.Popen(call, cwd=tmp_path)
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    again = {"period_init_ms": 100, "period_max_ms": 100}  # the run lasts some seconds only
    config.insert_json5(
        "connect", json.dumps({"endpoints": [endpoint], "timeout_ms": 30_000, "retry": again})
    )
    try:
        with zenoh.open(config) as session:
            heard = session.declare_subscriber(f"disknav/{run}/world/truth", zenoh.handlers.RingChannel(1))
            tells = {n: session.declare_publisher(f"disknav/{run}/robot/{n}/wish") for n in scenario.ids}
            while fleet.poll() is None:
                if (sample := heard.try_recv()) is None:
                    time.sleep(0.01)
                    continue
                _, _, robots, positions, *_ = msgpack.unpackb(sample.payload.to_bytes())
                for robot, (x, y) in zip(robots, positions, strict=True):
                    gx, gy = scenario.spec(robot).goal
                    rate = min(0.1 / max(math.hypot(gx - x, gy - y), 1e-9), 5.0)
                    tells[robot].put(msgpack.packb([kind_of_wish, robot, [rate * (gx - x), rate * (gy - y)]]))
    finally:
        if fleet.poll() is None:
            fleet.terminate()
        fleet.wait(30)
    result = json.loads((tmp_path / "result.json").read_text())
    assert min(result["path_lengths"].values()) > 0.05  # they did drive
    assert result["verdict"] != "collision"
    assert result["min_clearance"] > 0.0
