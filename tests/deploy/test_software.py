"""What is compiled does what its sources say, to the last bit, and no old one is run by mistake."""

import json
import os
import shutil
import subprocess
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.software import check_compiled, compiled
from protocol.errors import UsageError
from protocol.process.installation import ROOT
from tests.scripts import ended

_TWINS = pytest.mark.skipif(not compiled(), reason="nothing is compiled: `make compile`")
_SCENARIOS = ("figure-1", "delay-6", "forest-2", "warehouse-2", "turtlebots-3", "parts-1", "random-34")


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
    said = ended(script, *_SCENARIOS, timeout=240.0, cwd=tmp_path).stdout  # which comes first on its path
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


@pytest.mark.campaign
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_a_wheel_is_compiled(tmp_path: Path) -> None:
    """In an environment with what the build declares, and nothing else."""
    uv = shutil.which("uv") or str(Path(sys.executable).with_name("uv"))
    environment = {key: value for key, value in os.environ.items() if key != "HATCH_BUILD_NO_HOOKS"}
    subprocess.run(
        [uv, "build", "--quiet", "--wheel", "--out-dir", tmp_path, "--python", sys.executable, ROOT],
        env=environment,
        timeout=1200,
        check=True,
    )
    (wheel,) = tmp_path.glob("*.whl")
    assert not wheel.name.endswith("none-any.whl")
