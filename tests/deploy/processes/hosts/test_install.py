"""This software put on a host over ssh, into a folder of its own, and a fleet that runs from there."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from sysconfig import get_path

import pytest

from tests.deploy.processes.hosts.testbed.ssh_server import needs_sshd, ssh_server
from tests.deploy.processes.ports import free_ports

TABLE = """world = "base"

[[hosts]]
name = "base"
address = "127.0.0.1"
port = {ports[0]}
robots = [1, 2]

[[hosts]]
name = "far"
address = "127.0.0.1"
port = {ports[1]}
robots = [3, 4, 5, 6]
ssh = "{user}@127.0.0.1"
options = {options}
command = "{folder}/bin/disknav"
"""


def environment(lent: Path) -> dict[str, str]:
    """In which nothing is compiled, which takes minutes, and `make engines` tries it, too; and in which what
    this software depends on is there already, as it is here."""
    lent.mkdir()
    for each in Path(get_path("purelib")).iterdir():
        if "disknav" not in each.name:
            (lent / each.name).symlink_to(each)
    return {"HATCH_BUILD_NO_HOOKS": "true", "PYTHONPATH": str(lent)}


def disknav(*arguments: str, timeout: float) -> subprocess.CompletedProcess[str]:
    call = [sys.executable, "-m", "disknav", *arguments]
    return subprocess.run(call, capture_output=True, text=True, timeout=timeout, check=False)


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.timeout(300)
@needs_sshd
@pytest.mark.long(20)
def test_what_is_installed_there_is_fit_and_runs_its_robots(tmp_path: Path) -> None:
    folder, table = tmp_path / "there" / "disknav", tmp_path / "hosts.toml"
    with ssh_server(tmp_path, environment(tmp_path / "lent")) as server:
        options = json.dumps(list(server.options))
        table.write_text(TABLE.format(ports=free_ports(2), user=server.user, options=options, folder=folder))
        before = disknav("setup", "hosts", str(table), timeout=60.0)
        assert before.returncode == 1
        assert "No such file" in before.stdout + before.stderr or "not found" in before.stdout + before.stderr
        done = disknav("setup", "hosts", str(table), "--install", timeout=200.0)
        if "No matching distribution" in done.stderr:
            pytest.skip("no package index is reached from here: untested")
        assert done.returncode == 0, done.stderr
        assert not folder.with_name("disknav.sources").exists()
        fit = disknav("setup", "hosts", str(table), timeout=60.0)
        assert fit.returncode == 0, fit.stdout
        call = ["run", "figure-1", "--hosts", str(table), "--json", "-"]
        ran = disknav(*call, timeout=100.0)
        assert ran.returncode == 0, ran.stderr
        result = json.loads(ran.stdout)
    here = disknav("run", "figure-1", "--transport", "local", "--json", "-", timeout=60.0)
    assert result["trajectory_sha256"] == json.loads(here.stdout)["trajectory_sha256"]
    hosts = {each["name"]: each.get("host") for each in result["processes"]}
    assert hosts["robot-3"] == "far"
