"""systemd units: verified by systemd's own tool, and their command lines run until the robots arrive."""

import json
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import pytest

from deploy.manifests import ETC, Plan, write
from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster
from protocol.bus.zenoh import ZenohBus
from protocol.codec import decode
from protocol.keys import world_key
from protocol.scenario.file import write_toml
from tests.deploy.manifests.guested import ROBOTS, guested
from tests.deploy.processes.ports import free_ports
from tests.until import until

SCENARIO = guested("control.speed=0.3")
DISKNAV = str(Path(sys.executable).parent / "disknav")
ANALYZE = shutil.which("systemd-analyze")
needs_systemd = pytest.mark.skipif(ANALYZE is None, reason="systemd-analyze is not installed")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (port,) = free_ports(1)
    plan = Plan(
        KeyRoster("yard", ROBOTS), write_toml(SCENARIO), command=DISKNAV, router=f"tls/127.0.0.1:{port}"
    )
    write(tmp_path / "fleet", "systemd", plan)
    return tmp_path / "fleet"


def analyze(*arguments: str) -> subprocess.CompletedProcess[str]:
    assert ANALYZE is not None
    return subprocess.run([ANALYZE, *arguments], capture_output=True, text=True, timeout=60, check=False)


@needs_systemd
def test_systemd_accepts_the_units(folder: Path) -> None:
    done = analyze("verify", *map(str, [*folder.glob("*.service"), *folder.glob("*.target")]))
    assert (done.returncode, done.stderr) == (0, "")
    broken = folder / "disknav-yard-world.service"
    broken.write_text(broken.read_text().replace("NoNewPrivileges", "NoNewPrivilegez"))
    assert "NoNewPrivilegez" in analyze("verify", str(broken)).stderr


def test_software_in_a_home_is_shown_and_nothing_else_there(tmp_path: Path) -> None:
    """Whatever the modes of the folders above it; with spaces, colons and per cent signs in its path."""
    home = "/root/my fleet: 100%"
    plan = Plan(
        KeyRoster("yard", ROBOTS),
        write_toml(SCENARIO),
        command=f"{home}/env/bin/disknav",
        software=(f"{home}/env", "/usr"),
    )
    write(tmp_path / "fleet", "systemd", plan)
    unit = tmp_path / "fleet" / "disknav-yard-world.service"
    assert lines(unit, "ProtectHome") == ["tmpfs"]
    assert lines(unit, "BindReadOnlyPaths") == ['"/root/my fleet: 100%%/env"']
    (command,) = lines(unit, "ExecStart")
    assert command.startswith('"/root/my fleet: 100%%/env/bin/disknav" node world %d/')


@needs_systemd
@pytest.mark.parametrize("unit", ["router", "world", "robot@"])
def test_systemd_finds_them_hardly_exposed(folder: Path, unit: str) -> None:
    done = analyze(
        "security", "--offline=true", "--threshold=15", str(folder / f"disknav-yard-{unit}.service")
    )
    assert done.returncode == 0, done.stdout


def lines(unit: Path, directive: str) -> list[str]:
    return [
        line.partition("=")[2] for line in unit.read_text().splitlines() if line.startswith(f"{directive}=")
    ]


@contextmanager
def started(folder: Path, unit: str, instance: str = "") -> Iterator[subprocess.Popen[bytes]]:
    """Do what systemd does for a unit: hand over its credentials, start its command line, stop it."""
    path = folder / f"disknav-yard-{unit}.service"
    handed = folder.parent / f"{unit}{instance}"
    handed.mkdir(mode=0o700)
    for line in lines(path, "LoadCredential"):
        name, _, source = line.replace("%i", instance).partition(":")
        shutil.copy(source.replace(f"{ETC}/disknav-yard", str(folder)), handed / name)
        (handed / name).chmod(0o400)
    (command,) = lines(path, "ExecStart")
    process = subprocess.Popen(shlex.split(command.replace("%i", instance).replace("%d", str(handed))))
    try:
        yield process
    finally:
        process.terminate()
        process.wait(10.0)


@pytest.mark.process
@pytest.mark.timeout(150)
@pytest.mark.long(10)
def test_the_units_command_lines_are_a_fleet_that_arrives(folder: Path) -> None:
    (listen,) = lines(folder / "disknav-yard-router.service", "ExecStart")
    endpoint = listen.split("--listen ")[1].split()[0]
    monitor = KeyRing(folder / "keys").client("monitor", (endpoint,))
    with ExitStack() as stack:
        stack.enter_context(started(folder, "router"))
        bus = stack.enter_context(closing(ZenohBus(monitor)))
        bus.subscribe(world_key("yard", "result"))
        world = stack.enter_context(started(folder, "world"))
        first, *others = map(str, ROBOTS)
        robots = [stack.enter_context(started(folder, "robot@", first))]
        probes = []  # they are answered while the world waits for the others; the run itself is a short one
        for role, keys in (("world", "world"), (f"robot-{first}", f"robot@{first}")):
            probing = [DISKNAV, "fleet", "probe", "yard", role, "--router", endpoint, "--within", "60"]
            probes.append(subprocess.Popen([*probing, "--secure", str(folder.parent / keys)]))
        patience = time.monotonic() + 10.0
        while any(probe.poll() is None for probe in probes) and time.monotonic() < patience:
            time.sleep(0.02)
        robots += [stack.enter_context(started(folder, "robot@", robot)) for robot in others]
        assert [probe.wait(70.0) for probe in probes] == [0, 0]
        sample = until(lambda: bus.receive(0.1), 60.0, "no result")
        report = json.loads(decode(sample.key, sample.payload).report)
        assert (report["verdict"], report["robots"]) == ("arrived", list(ROBOTS))
        assert world.wait(10.0) == 0
        assert [robot.wait(10.0) for robot in robots] == [0] * len(robots)
