"""Files with which Docker Compose, Kubernetes or systemd runs a secured fleet, filled in from templates."""

from __future__ import annotations

import json
import os
import sys
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from string import Template
from typing import Literal

import deploy
from deploy.output import whole_folder
from deploy.run.options import Mode
from deploy.security.roster import ROSTER, ROUTER, WORLD, KeyRoster, robot_role
from protocol.bus.connection import AUTHORITY, certificate_file, key_file
from protocol.errors import UsageError

SCENARIO = "scenario.toml"
KEYS = "keys"  # the folder of keys beside the files
PORT = 7447
IMAGE = "localhost/disknav"  # a name that no registry can serve
KEYS_INSIDE = "/keys"  # folder of a container's own keys


@dataclass(frozen=True)
class Plan:
    """A run, its scenario, and its installation."""

    roster: KeyRoster
    scenario: str  # TOML
    mode: Mode = "realtime"
    image: str = IMAGE  # container image with this software
    command: str = "/usr/local/bin/disknav"  # command of this software on a host
    software: tuple[str, ...] = ()  # folders that it needs on a host
    router: str = f"tls/127.0.0.1:{PORT}"  # endpoint of the router
    wait: float = 300.0  # s to wait for router, world and robots, started in any order

    @property
    def name(self) -> str:
        """Name of all objects of this run: letters, digits and '-' only."""
        return f"disknav-{self.roster.run}".lower().replace("_", "-").rstrip("-")

    @property
    def robots(self) -> tuple[str, ...]:
        """Roles of all robots, including those that orders add."""
        return tuple(robot_role(robot) for robot in self.roster.robots)

    def files(self, role: str) -> tuple[str, ...]:
        """Key files of a role."""
        return (AUTHORITY, ROSTER, certificate_file(role), key_file(role))


def join(role: str, router: str, keys: str, plan: Plan, scenario: str) -> list[str]:
    """Command line, after `disknav`, of the world or a robot."""
    connection = ["--router", router, "--secure", keys, "--wait", f"{plan.wait:g}"]
    if role.startswith("robot-"):
        return ["node", "robot", role.removeprefix("robot-"), *connection]
    return ["node", "world", scenario, "--mode", plan.mode, *connection]


def listen(endpoint: str, keys: str) -> list[str]:
    """Command line, after `disknav`, of the router."""
    return ["node", "router", "--listen", endpoint, "--secure", keys]


def installation() -> tuple[str, ...]:
    """Folders of this host that the software needs: environment, interpreter, sources."""
    folders = (sys.prefix, sys.base_prefix, *(str(Path(each).parent) for each in deploy.__path__))
    return tuple(dict.fromkeys(str(Path(folder).resolve()) for folder in folders))


SECRET = "secret.yaml"  # kubernetes: holds private keys
ETC = "/etc/disknav"  # systemd: contains the folder of a run
STALE = 10  # s without a heartbeat after which a process hangs
_TEMPLATES = Path(__file__).parent / "templates"
_CONFIG_INSIDE = "/config"
_SCRATCH = "/tmp"  # the only folder that a container may write to, in memory
_ALIVE = f"{_SCRATCH}/alive"
# Whether the main loop runs; with two tools of the system, without interpreter or connection.
PROBE = f"test $(($(date +%s) - $(stat -c %Y {_ALIVE}))) -lt {STALE}"
_BUILD = "In a checkout of disknav: docker build -t {image} -f Containerfile ."
_ACCOUNT = 65532  # user id of containers in a cluster
_PICK = 'set -- $ROBOTS; shift "$INDEX"; exec disknav '  # selects the id of this pod's index
_HOMES = ("/home/", "/root/", "/run/user/")


def router_host(orchestrator: str, plan: Plan) -> str:
    """Name or address of the router for the fleet."""
    if orchestrator == "compose":
        return ROUTER
    if orchestrator == "kubernetes":
        return f"{plan.name}-{ROUTER}"
    return plan.router.partition("/")[2].rpartition(":")[0].strip("[]")


def compose(plan: Plan) -> dict[str, str]:
    """Docker Compose: a service for each process, with its own key only. Returns files by name.

    The containers run as the user of this process, the owner of the keys.
    """
    roles = (ROUTER, WORLD, *plan.robots)
    robots = [
        _filled(
            "compose-robot.yaml",
            role=role,
            command=json.dumps(_member("compose", plan, role)),
            keys=_mounted(plan, role),
        )
        for role in plan.robots
    ]
    names = sorted({name for role in roles for name in plan.files(role)})
    text = _filled(
        "compose.yaml",
        **_common(plan),
        user=f"{os.getuid()}:{os.getgid()}",
        probe=json.dumps(PROBE.replace("$", "$$")),  # Compose would replace $NAME
        wait=f"{plan.wait:.0f}",
        router=json.dumps(listen(f"tls/0.0.0.0:{PORT}", KEYS_INSIDE)),
        router_keys=_mounted(plan, ROUTER),
        world=json.dumps(_member("compose", plan, WORLD)),
        world_keys=_mounted(plan, WORLD),
        scenario_inside=f"{_CONFIG_INSIDE}/{SCENARIO}",
        robots="".join(robots),
        secrets="\n".join(f"  {name}: {{file: ./{KEYS}/{name}}}" for name in names),
    )
    return {"compose.yaml": text, SCENARIO: plan.scenario}


def kubernetes(plan: Plan, keys: Mapping[str, bytes]) -> dict[str, str]:
    """Kubernetes: a Deployment for the router, a Job for the world, an indexed Job for the robots.

    `keys` are the files of the directory of keys. Returns files by name.
    """
    robot = _PICK + " ".join(_member("kubernetes", plan, "robot-$1"))
    alive = _filled("kubernetes-alive.yaml", probe=json.dumps(PROBE), patience=str(ceil(plan.wait / 5) + 6))
    indexed = [(f"{index}/", role) for index, role in enumerate(plan.robots)]
    text = _filled(
        "kubernetes.yaml",
        **_common(plan),
        scenario=json.dumps(plan.scenario),
        pod=_filled("kubernetes-pod.yaml", account=str(_ACCOUNT)).rstrip("\n"),
        container=_filled("kubernetes-container.yaml", image=plan.image).rstrip("\n"),
        alive=alive.rstrip("\n"),
        config_inside=_CONFIG_INSIDE,
        keys_inside=KEYS_INSIDE,
        router=json.dumps(["disknav", *listen(f"tls/0.0.0.0:{PORT}", KEYS_INSIDE)]),
        world=json.dumps(["disknav", *_member("kubernetes", plan, WORLD)]),
        robot=json.dumps(robot),
        ids=" ".join(map(str, plan.roster.robots)),
        count=str(len(plan.robots)),
        retries=str(3 * len(plan.robots)),
        router_keys=_items(plan, [("", ROUTER)]),
        world_keys=_items(plan, [("", WORLD)]),
        robot_keys=_items(plan, indexed),
    )
    data = {name: b64encode(content).decode() for name, content in sorted(keys.items())}
    secret = _filled("kubernetes-secret.yaml", name=plan.name, data=json.dumps(data, indent=2))
    return {"fleet.yaml": text, SECRET: secret}


def systemd(plan: Plan) -> dict[str, str]:
    """systemd: units for router and world, a template for robots, a target for all. Returns files by name."""
    name, folder = plan.name, f"{ETC}/{plan.name}"
    units = [f"{name}-{role.replace('-', '@')}.service" for role in plan.robots]
    target = _filled(
        "systemd.target",
        **_common(plan),
        folder=folder,
        keys_folder=KEYS,
        wanted=" ".join([f"{name}-{ROUTER}.service", f"{name}-{WORLD}.service", *units]),
    )
    watched = "WatchdogSec=10"  # the main loop notifies every second
    router, world = listen(plan.router, "%d"), join(WORLD, plan.router, "%d", plan, f"%d/{SCENARIO}")
    robot = join("robot-%i", plan.router, "%d", plan, "")
    return {
        f"{name}.target": target,
        f"{name}-{ROUTER}.service": _service(plan, ROUTER, router, "Restart=always\nRestartSec=1"),
        # Not restarted: the fleet would continue from other positions than the robots'.
        f"{name}-{WORLD}.service": _service(plan, WORLD, world, f"Restart=no\n{watched}", more=(SCENARIO,)),
        f"{name}-robot@.service": _service(
            plan, "robot-%i", robot, f"Restart=on-failure\nRestartSec=1\n{watched}"
        ),
        SCENARIO: plan.scenario,
    }


def _service(plan: Plan, role: str, arguments: Sequence[str], restart: str, more: Sequence[str] = ()) -> str:
    folder = f"{ETC}/{plan.name}"
    loads = [f"LoadCredential={name}:{folder}/{KEYS}/{name}" for name in plan.files(role)]
    loads += [f"LoadCredential={name}:{folder}/{name}" for name in more]
    after = ["network-online.target", *([] if role == ROUTER else [f"{plan.name}-{ROUTER}.service"])]
    return _filled(
        "systemd.service",
        name=plan.name,
        run=plan.roster.run,
        what=role.replace("-", " ").capitalize(),
        after=" ".join(after),
        patience=f"{plan.wait + 30:.0f}",
        command=" ".join([_quoted(plan.command), *arguments]),
        credentials="\n".join(loads),
        restart=restart,
        home=_home(plan),
    )


def _home(plan: Plan) -> str:
    there = [path for path in plan.software if path.startswith(_HOMES)]
    if not there:
        return "ProtectHome=yes"
    return "\n".join(["ProtectHome=tmpfs", *(f"BindReadOnlyPaths={_quoted(path)}" for path in there)])


def _quoted(path: str) -> str:
    escaped = path.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%")
    return f'"{escaped}"' if escaped != path or set(path) & set(" :") else path


def _common(plan: Plan) -> dict[str, str]:
    return {
        "name": plan.name,
        "run": plan.roster.run,
        "image": plan.image,
        "build": _BUILD.format(image=plan.image),
        "port": str(PORT),
        "scratch": _SCRATCH,
        "scenario_file": SCENARIO,
    }


def _member(orchestrator: str, plan: Plan, role: str) -> list[str]:
    """Command line, after `disknav`, of the world or a robot in a container."""
    endpoint = f"tls/{router_host(orchestrator, plan)}:{PORT}"
    command = join(role, endpoint, KEYS_INSIDE, plan, f"{_CONFIG_INSIDE}/{SCENARIO}")
    return [*command, "--alive", _ALIVE]


def _mounted(plan: Plan, role: str) -> str:
    """Compose: keys of one role as a YAML list."""
    return json.dumps([{"source": name, "target": f"{KEYS_INSIDE}/{name}"} for name in plan.files(role)])


def _items(plan: Plan, folders: Sequence[tuple[str, str]]) -> str:
    """Kubernetes: keys of some roles from the secret, each under a folder, as a YAML list."""
    return json.dumps(
        [{"key": name, "path": f"{folder}{name}"} for folder, role in folders for name in plan.files(role)]
    )


def _filled(template: str, **values: str) -> str:
    return Template((_TEMPLATES / template).read_text(encoding="utf-8")).substitute(values)


Orchestrator = Literal["compose", "kubernetes", "systemd"]


def write(folder: Path, orchestrator: Orchestrator, plan: Plan, days: float = 30.0) -> None:
    """Create `folder` with all files for `orchestrator`, whole or not at all, readable by its owner only.
    Raises UsageError if the folder is not empty, or a library is missing.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{folder} exists and is not empty: name another folder")
    from deploy.security.keystore import create

    with whole_folder(folder) as fresh:
        create(fresh / KEYS, plan.roster, hosts=(router_host(orchestrator, plan),), days=days)
        for name, text in _files(orchestrator, plan, fresh / KEYS).items():
            path = fresh / name
            path.touch(mode=0o600 if name == SECRET else 0o644)
            path.write_text(text, encoding="utf-8")


def _files(orchestrator: Orchestrator, plan: Plan, keys: Path) -> Mapping[str, str]:
    if orchestrator == "compose":
        return compose(plan)
    if orchestrator == "kubernetes":
        return kubernetes(plan, {path.name: path.read_bytes() for path in keys.iterdir()})
    return systemd(plan)
