"""Compose and Kubernetes files: by their own schemas, and by what must not be in them."""

import os
import subprocess
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from deploy import manifests
from deploy.library.load import load
from deploy.manifests import Plan, write
from deploy.run.operator import probed_key
from deploy.security.roster import KeyRoster
from protocol.bus.bus import PERIOD, Heartbeat
from protocol.errors import UsageError
from protocol.scenario.file import parse_toml, write_toml
from protocol.scenario.model import Order, RobotSpec
from tests.forks import Forks

ROSTER = KeyRoster("Yard_7", (1, 2, 5))
SCENARIO = load("figure-2", [], 4)


def written(tmp_path: Path, orchestrator: Any) -> Path:
    write(tmp_path / "fleet", orchestrator, Plan(ROSTER, write_toml(SCENARIO)))
    return tmp_path / "fleet"


def documents(path: Path) -> list[dict[str, Any]]:
    return list(yaml.safe_load_all(path.read_text()))


def test_compose_follows_its_specification(tmp_path: Path) -> None:
    import compose_spec

    folder = written(tmp_path, "compose")
    (document,) = documents(folder / "compose.yaml")  # with its anchors followed
    project = compose_spec.PyCompose.from_yaml(yaml.safe_dump(document))
    project.validate()
    assert set(project.service_names()) == {"router", "world", "robot-1", "robot-2", "robot-5"}


def test_compose_gives_everybody_their_own_key_and_no_privileges(tmp_path: Path) -> None:
    folder = written(tmp_path, "compose")
    (project,) = documents(folder / "compose.yaml")
    for role, service in project["services"].items():
        secrets = {secret["source"] for secret in service["secrets"]}
        assert {name for name in secrets if name.endswith(".key")} == {f"{role}.key"}
        assert service["cap_drop"] == ["ALL"]
        assert service["read_only"] is True
        assert "ports" not in service
        assert service["image"] == "localhost/disknav"  # not an image of a registry
    assert all((folder / entry["file"]).is_file() for entry in project["secrets"].values())
    assert parse_toml((folder / "scenario.toml").read_text()) == SCENARIO
    assert project["services"]["world"]["volumes"] == ["./scenario.toml:/config/scenario.toml:ro"]
    assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.slow
def test_kubernetes_follows_its_schemas(tmp_path: Path) -> None:
    import kubernetes_validate

    folder = written(tmp_path, "kubernetes")
    kinds = []
    for name in ("fleet.yaml", "secret.yaml"):
        for document in documents(folder / name):
            kubernetes_validate.validate(document, "1.33", strict=True)
            kinds.append(document["kind"])
    assert kinds == ["ConfigMap", "Service", "Deployment", "Job", "Job", "Secret"]


GUEST = RobotSpec(3, 0.02, (0.0, 0.2), (0.0, 0.25))
THIRD = {
    "compose": ("compose.yaml", "  robot-3:"),
    "kubernetes": ("fleet.yaml", 'value: "1 2 3"'),
    "systemd": ("disknav-yard.target", "disknav-yard-robot@3.service"),
}


def deployed(
    disknav: Forks, folder: Path, orchestrator: str, guest: RobotSpec
) -> subprocess.CompletedProcess[str]:
    scenario = replace(load("swap-2"), orders=(Order(1.0, remove=2), Order(2.0, add=guest)))
    (folder / "guest.toml").write_text(write_toml(scenario))
    return disknav(
        "setup", "deploy", orchestrator, folder / "guest.toml", "-o", folder / "fleet", "--run", "yard"
    )


@pytest.mark.slow
@pytest.mark.parametrize("orchestrator", THIRD)
def test_a_robot_that_orders_add_is_started_too(disknav: Forks, tmp_path: Path, orchestrator: str) -> None:
    assert deployed(disknav, tmp_path, orchestrator, GUEST).returncode == 0
    assert (tmp_path / "fleet" / "keys" / "robot-3.key").is_file()
    name, words = THIRD[orchestrator]
    assert words in (tmp_path / "fleet" / name).read_text()


@pytest.mark.slow
def test_no_orchestrator_starts_a_removed_process_again(disknav: Forks, tmp_path: Path) -> None:
    done = deployed(disknav, tmp_path, "systemd", replace(GUEST, id=2))
    assert done.returncode == 2
    assert "robot 2 again" in done.stderr


def test_a_pod_at_an_index_runs_the_robot_whose_keys_it_sees(tmp_path: Path) -> None:
    robots = documents(written(tmp_path, "kubernetes") / "fleet.yaml")[-1]["spec"]
    assert (robots["completions"], robots["completionMode"]) == (3, "Indexed")
    pod = robots["template"]["spec"]["containers"][0]
    items = robots["template"]["spec"]["volumes"][0]["secret"]["items"]
    listed = next(entry["value"] for entry in pod["env"] if entry["name"] == "ROBOTS")
    for index, robot in enumerate(ROSTER.robots):
        shell = pod["command"][-1].replace("exec disknav", "exec echo")
        environment = {"ROBOTS": listed, "INDEX": str(index), "PATH": "/usr/bin:/bin"}
        done = subprocess.run(["/bin/sh", "-c", shell], env=environment, capture_output=True, check=True)
        assert done.stdout.decode().split()[:3] == ["node", "robot", str(robot)]
        seen = {item["key"] for item in items if item["path"].startswith(f"{index}/")}
        assert {name for name in seen if name.endswith(".key")} == {f"robot-{robot}.key"}


def test_kubernetes_pods_are_confined_and_probed_on_their_health(tmp_path: Path) -> None:
    folder = written(tmp_path, "kubernetes")
    objects = [document.get("spec", {}) for document in documents(folder / "fleet.yaml")]
    templates = [spec["template"]["spec"] for spec in objects if "template" in spec]
    assert len(templates) == 3
    for pod in templates:
        assert pod["securityContext"]["runAsNonRoot"] is True
        (running,) = pod["containers"]
        assert running["securityContext"]["capabilities"] == {"drop": ["ALL"]}
        assert {"livenessProbe", "startupProbe"} <= set(running)
        assert running["image"] == "localhost/disknav"
    assert (folder / "secret.yaml").stat().st_mode & 0o077 == 0
    assert probed_key("r", "robot-5") == "disknav/r/robot/5/health"


def test_the_probe_tells_a_loop_that_goes_round_from_one_that_hangs(tmp_path: Path) -> None:
    alive = tmp_path / "alive"
    command = manifests.PROBE.replace("/tmp/alive", str(alive))

    def well() -> bool:
        return subprocess.run(["/bin/sh", "-c", command], capture_output=True, check=False).returncode == 0

    assert str(alive) in command
    assert not well()
    beat = Heartbeat(alive)
    beat(0.0)
    assert well()
    os.utime(alive, (time.time() - manifests.STALE,) * 2)
    assert not well()
    beat(0.5)  # too soon to be told again
    assert not well()
    beat(PERIOD)
    assert well()


def test_a_router_or_a_monitor_cannot_be_probed() -> None:
    for role in ("router", "monitor", "robot-x"):
        with pytest.raises(UsageError, match="cannot be probed"):
            probed_key("r", role)


@pytest.mark.slow
def test_a_folder_with_something_in_it_is_left_alone(disknav: Forks, tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("mine")
    done = disknav("setup", "deploy", "compose", "figure-2", "-o", tmp_path)
    assert done.returncode == 2
    assert "not empty" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["notes"]
