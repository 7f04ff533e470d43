"""What README shows runs: its commands, its scenario, its links."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from deploy.library.load import resolved
from deploy.run.local import LocalFleet
from protocol.scenario.file import parse_toml

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
PREFIX = ".venv/bin/disknav "
COMMANDS = [line.split("#")[0].strip() for line in README.splitlines() if line.startswith(PREFIX)]
QUICK = {"run": ["--quiet"], "check": ["--json"], "certify": ["--quiet"], "--help": []}


@pytest.mark.process
@pytest.mark.timeout(250)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command(command: str, tmp_path: Path) -> None:
    words = shlex.split(command.removeprefix(PREFIX))
    call = [sys.executable, "-m", "deploy.cli", *words, *QUICK[words[0]]]
    if "realtime" in words:
        call += ["--json", "result.json"]
    done = subprocess.run(
        call, cwd=tmp_path, env={"PYTHONPATH": str(ROOT)}, stdin=subprocess.DEVNULL, timeout=240, check=False
    )
    if "realtime" not in words:
        assert done.returncode == 0
        return
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["collisions"] == 0
    assert result["verdict"] in ("arrived", "timeout")  # a slow machine may not get there in real time


def test_there_are_commands() -> None:
    assert len(COMMANDS) >= 5


def test_the_scenario() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    (report,) = LocalFleet([resolved(parse_toml(text, "README"))]).execute()
    assert report["verdict"] == "arrived"


@pytest.mark.parametrize("target", sorted(set(re.findall(r"\]\(([^)#:]+)\)", README))))
def test_a_link(target: str) -> None:
    assert (ROOT / target).exists()


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"^make ([a-z]+)", README, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
