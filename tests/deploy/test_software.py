"""What is compiled does what its sources say, to the last bit, and no old one is run by mistake."""

import json
import os
import shutil
import subprocess
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest

from agents.law.flow import Flow, desired_velocity
from agents.law.gradient import Slice
from agents.peers.state import Peer
from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.software import check_compiled, compiled
from protocol.errors import UsageError
from protocol.process.installation import ROOT
from tests.interpreted import interpreted

_TWINS = pytest.mark.skipif(not compiled(), reason="nothing is compiled: `make compile`")
_SCENARIOS = ("figure-1", "delay-6", "forest-2", "warehouse-2", "turtlebots-3", "parts-1", "random-34")


@_TWINS
@pytest.mark.parametrize("seed", range(10))
def test_the_law_is_the_same_to_the_last_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    k = float(10 ** rng.uniform(0.5, 4.0))
    own, goal, *others = rng.uniform(-0.2, 0.2, (8, 2)).tolist()
    peers = [(*place, 0.03, float(rng.uniform(0.0, 0.05))) for place in others]
    as_written, flow = interpreted("agents.law.gradient", "agents.law.flow")
    one = Slice(tuple(goal), 0.03, 0.30, k, [Peer(*peer) for peer in peers])
    other = as_written.Slice(tuple(goal), 0.03, 0.30, k, [as_written.Peer(*peer) for peer in peers])
    numbers = attrgetter("dx", "dy", "xx", "xy", "yx", "yy")
    assert numbers(one.gradient(*own)) == numbers(other.gradient(*own))
    assert desired_velocity(Flow(one, 2.0), tuple(own), period=0.05, speed=0.1) == flow.desired_velocity(
        flow.Flow(other, 2.0), tuple(own), period=0.05, speed=0.1
    )


@_TWINS
@pytest.mark.slow
def test_trajectories_are_those_of_the_sources(tmp_path: Path) -> None:
    for package in ("protocol", "agents", "world", "deploy"):
        shutil.copytree(
            ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("*.so", "__pycache__")
        )
    script = (
        "import json, sys; from deploy.library.load import load; from deploy.run.local import LocalFleet\n"
        "print(json.dumps([LocalFleet(load(name, ['time.limit=5'])).execute() for name in sys.argv[1:]]))"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    said = subprocess.run(
        [sys.executable, "-c", script, *_SCENARIOS],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        timeout=240,
        check=True,
    ).stdout
    for name, source in zip(_SCENARIOS, json.loads(said), strict=True):
        twin = LocalFleet(load(name, ["time.limit=5"])).execute()
        same = ("trajectory_sha256", "min_clearance", "nrl", "phi", "ticks")
        assert {key: source[key] for key in same} == {key: twin[key] for key in same}


def test_an_old_twin_is_refused(tmp_path: Path) -> None:
    source = tmp_path / "agents" / "law.py"
    source.parent.mkdir()
    twin = source.with_suffix(EXTENSION_SUFFIXES[0])
    for path in (source, twin):
        path.touch()
    os.utime(source, (1.0, 1.0))
    check_compiled(tmp_path)
    os.utime(source, (2e9, 2e9))
    os.utime(twin, (1e9, 1e9))
    with pytest.raises(UsageError, match=r"agents/law\.py has changed since it was compiled"):
        check_compiled(tmp_path)
