"""Obstacles that come and go while a fleet runs: acknowledged, refused by reason, remembered, drawn."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from deploy.library.load import load
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.telemetry.plot.workspace import stays
from deploy.telemetry.recording.reader import read
from protocol.messages import Clock
from protocol.scenario.model import Obstacle
from tests.forks import Forks
from tests.system.orders.turnover import asked

SWAP = load("swap-4")
LISTED = replace(SWAP, obstacles=(Obstacle(center=(0.2, 0.2), radius=0.02),))
BAR = {"place": {"points": [[-0.02, -0.01], [0.02, -0.01], [0.02, 0.01], [-0.02, 0.01]]}}


def test_a_recording_says_from_when_until_when(tmp_path: Path) -> None:
    with LocalFleet(LISTED, record=tmp_path / "run.mcap", speed=20.0) as fleet:
        for tick in range(60):
            assert fleet.step()
            if tick == 10:
                assert asked(fleet, BAR).accepted
            if tick == 40:
                assert asked(fleet, {"take": 1}).accepted
        fleet.world.interrupt("interrupted", "enough")
        fleet.execute()
    first, second = stays(read(tmp_path / "run.mcap"))
    assert (first.since, second.until) == (0.0, math.inf)
    assert 0.5 < second.since < 1.5 < first.until < 3.0
    assert second.words == f"from {second.since:.1f} s"


@pytest.mark.process
@pytest.mark.timeout(120)
def test_from_the_command_line(disknav: Forks) -> None:
    said: list[tuple[int, str]] = []

    def say(*words: str) -> None:
        done = disknav("fleet", *words)
        said.append((done.returncode, done.stdout + done.stderr))

    scenario = replace(LISTED, time=replace(SWAP.time, endless=True))
    clocks, options = list[Clock](), RunOptions(speed=1.0)
    with Fleet(scenario, options, watch=clocks.append) as fleet:

        def enough() -> bool:
            if clocks and clocks[-1].founded and not said:
                (endpoint,) = fleet.topology.observer().connect
                run, router = options.run, ("--router", endpoint)
                say("place", run, "-0.19", "-0.19", "--radius", "0.02", *router)  # in no robot's way
                say("place", run, "0.0", "0.0", "0.1", "0.1", "0.1", "0.0", "0.0", "0.1", *router)
                say("take", run, "1", *router)
                say("take", run, "1", *router)
                say("things", run, "--json", *router)
            return bool(said)

        fleet.execute(enough)
    codes = [code for code, _ in said]
    assert codes == [0, 2, 0, 1, 0], said
    assert "obstacle 2 is in place" in said[0][1]
    assert "sides cross" in said[1][1]
    assert "no obstacle 1" in said[3][1]
    assert [obstacle["number"] for obstacle in json.loads(said[4][1])] == [2]
