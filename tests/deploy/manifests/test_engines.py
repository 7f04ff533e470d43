"""What is written for orchestrators, started by them, cold: podman-compose, pods, systemd as it boots."""

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from deploy import manifests
from deploy.manifests import Plan, write
from deploy.security.roster import KeyRoster
from protocol.scenario.file import write_toml
from tests.deploy.manifests.engine import IMAGE, command, environment, needs_engine, podman
from tests.deploy.manifests.guested import ROBOTS, guested
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.slow, pytest.mark.timeout(240), needs_engine]

SCENARIO = guested()
PATIENCE = 90.0


def report(text: str) -> dict[str, Any]:
    """The world's report, out of what it and others printed."""
    return json.JSONDecoder().raw_decode(text[text.index("{\n") :])[0]


def all_arrived(text: str) -> bool:
    found = report(text)
    return (found["verdict"], found["robots"]) == ("arrived", list(ROBOTS))


def test_the_image_is_compiled_and_drives_a_fleet() -> None:
    where = ["--entrypoint", "/opt/disknav/bin/python", IMAGE, "-c"]
    found = podman("run", "--rm", "--network=none", *where, "import agents.robot as it; print(it.__file__)")
    assert found.stdout.strip().endswith(".so")
    confined = ["--rm", "--network=none", "--read-only", "--cap-drop=ALL"]
    done = podman("run", *confined, IMAGE, "run", "figure-2", "--transport", "local", "--json", "-")
    assert report(done.stdout)["verdict"] == "arrived"


@contextmanager
def composed(folder: Path) -> Iterator[Callable[..., None]]:
    """What brings up services of the project in `folder`; all go at the end."""
    wrapper = folder.parent / "podman"
    wrapper.write_text("#!/bin/sh\nexec " + " ".join(command()) + ' "$@"\n')
    wrapper.chmod(0o700)

    def compose(*arguments: str) -> None:
        call = ["podman-compose", "--podman-path", str(wrapper), *arguments]
        subprocess.run(call, cwd=folder, env=environment(), timeout=PATIENCE, check=True, capture_output=True)

    try:
        yield lambda *services: compose("up", "--detach", *services)
    finally:
        compose("down")


@pytest.mark.skipif(shutil.which("podman-compose") is None, reason="no podman-compose: untested here")
def test_compose_brings_up_a_fleet_that_arrives(tmp_path: Path) -> None:
    it = Plan(KeyRoster("composed", ROBOTS), write_toml(SCENARIO), wait=60.0)
    write(tmp_path / "fleet", "compose", it)
    with composed(tmp_path / "fleet") as up:
        up("router", "world")
        names = podman("ps", "--all", "--format", "{{.Names}}").stdout.split()
        world = next(name for name in names if "world" in name)
        probe = ["exec", world, "/bin/sh", "-c", manifests.PROBE]
        until(lambda: podman(*probe, check=False).returncode == 0, PATIENCE)  # it waits for its robots
        up(*it.robots)
        status = podman("wait", world, timeout=PATIENCE).stdout.strip()
        logs = podman("logs", world)
        assert status == "0", logs.stderr
        assert all_arrived(logs.stdout)


# A home of mode 0700 with an environment in it, and spaces in its path, that sees the libraries of the image.
_SETTLE = r"""
set -e
mkdir -m 0700 -p "$HOME/my fleet"; chmod 0700 "$HOME"
/opt/disknav/bin/python -m venv --without-pip "$HOME/my fleet/env"
cd "$HOME/my fleet"
echo /opt/disknav/lib/python3*/site-packages > "$(echo env/lib/python3*/site-packages)/all.pth"
printf '#!/bin/sh\nexec "%s/env/bin/python" -m disknav "$@"\n' "$PWD" > env/bin/disknav
chmod 755 env/bin/disknav
cat > guested.toml <<"EOF"
SCENARIO_TOML
EOF
env/bin/disknav setup deploy systemd guested.toml --run yard --wait 60 --out yard
"""


@contextmanager
def booted() -> Iterator[Callable[..., str]]:
    """A system that has booted under systemd; gives a shell there."""
    name = "disknav-booted"
    init = ["--systemd=always", "--privileged", "--user=0", "--entrypoint", "/bin/sh"]
    # In a container systemd leaves it to the engine that mounts made for a unit are seen by it.
    boot = ["-c", "mount --make-rshared / && exec /sbin/init"]

    def shell(text: str, *, check: bool = True) -> str:
        done = podman(
            "exec", "--env", "HOME=/root", name, "/bin/sh", "-c", text, check=check, timeout=PATIENCE
        )
        return done.stdout

    podman("rm", "--force", "--ignore", name)
    podman("run", "--detach", "--rm", "--name", name, *init, IMAGE, *boot)
    try:
        until(
            lambda: shell("systemctl is-system-running", check=False).strip() in ("running", "degraded"),
            PATIENCE,
        )
        yield shell
    finally:
        podman("rm", "--force", "--time=0", name)


def test_systemd_starts_units_whose_software_is_in_a_private_home() -> None:
    with booted() as shell:
        shell(_SETTLE.replace("SCENARIO_TOML", write_toml(SCENARIO)))
        target = shell('cat "$HOME/my fleet/yard/disknav-yard.target"')
        steps = [line[1:].strip() for line in target.splitlines() if line.startswith("#   ")]
        assert len(steps) == 2
        shell('cd "$HOME/my fleet/yard" && ' + " && ".join(steps))
        world = "systemctl show disknav-yard-world --property=ActiveState,ExecMainStatus,Result"
        until(lambda: "ActiveState=inactive" in shell(world) or "failed" in shell(world), PATIENCE)
        journal = shell("journalctl --no-pager --output=cat --unit=disknav-yard-world")
        assert set(shell(world).split()) == {"ActiveState=inactive", "ExecMainStatus=0", "Result=success"}, (
            shell("journalctl --no-pager --lines=80")
        )
        assert all_arrived(journal)
        for robot in ROBOTS:
            unit = f"systemctl show disknav-yard-robot@{robot} --property=Result,NRestarts"
            assert set(shell(unit).split()) == {"Result=success", "NRestarts=0"}
