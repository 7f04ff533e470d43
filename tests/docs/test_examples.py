"""Each example has a page with a picture and a command or a short script; the scripts run.

`test_shown_commands.py` runs the commands of the pages.
"""

import json
import shutil
from pathlib import Path

import pytest

from tests.deploy.processes.ports import free_ports
from tests.scripts import ROOT, ended

EXAMPLES = ROOT / "docs/examples"


def run(folder: str, script: str, *words: str, cwd: Path) -> str:
    shutil.copytree(EXAMPLES / folder, cwd, dirs_exist_ok=True)
    done = ended(Path(script), *words, timeout=120.0, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.process
@pytest.mark.long(12)
def test_a_fleet_that_lives(tmp_path: Path) -> None:
    said = run("03-living-fleet", "orders.py", f"tcp/127.0.0.1:{free_ports(1)[0]}", cwd=tmp_path)
    assert "robot=3" in said
    assert "status='arrived', goal=(0.15, 0.05)" in said
    assert (tmp_path / "yard.mcap").stat().st_size > 10_000


@pytest.mark.campaign
def test_two_routers(tmp_path: Path) -> None:
    run("08-several-hosts", "two_routers.py", *map(str, free_ports(2)), cwd=tmp_path)


@pytest.mark.slow
def test_a_study_is_drawn(tmp_path: Path) -> None:
    study = tmp_path / "tuning.json"
    rows = [
        {"k": k, "nrl_mean": n, "nrl_std": 0.1, "paper": None, "exact": 1.1}
        for k, n in ((5.0, None), (60.0, 1.2))
    ]
    study.write_text(json.dumps({"rows": rows}))
    run("01-figures", "draw.py", study.name, "k", "nrl_mean", cwd=tmp_path)
    assert study.with_suffix(".png").stat().st_size > 5_000


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import disknav

    path = tmp_path_factory.mktemp("recording") / "figure-1.mcap"
    disknav.run("figure-1", record=path)
    return path


@pytest.mark.slow
def test_speeds_of_a_recording(recording: Path, tmp_path: Path) -> None:
    run("09-recording", "speeds.py", str(recording), cwd=tmp_path)


@pytest.mark.campaign
def test_a_policy_is_trained_and_shown(tmp_path: Path) -> None:
    run("10-learning", "train.py", "1", cwd=tmp_path)
    run("10-learning", "show.py", "1", cwd=tmp_path)


@pytest.mark.slow
def test_poses_for_ros2(recording: Path, tmp_path: Path) -> None:
    from deploy.telemetry.recording.reader import read
    from deploy.telemetry.recording.replay import export

    export(read(recording), tmp_path / "poses.mcap")
    run("07-ros2", "poses.py", "poses.mcap", cwd=tmp_path)
