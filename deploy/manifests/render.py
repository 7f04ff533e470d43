"""The files of each orchestrator: the templates beside this module, filled in for one run."""

from __future__ import annotations

import json
import os
from base64 import b64encode
from collections.abc import Mapping, Sequence
from math import ceil
from pathlib import Path
from string import Template

from deploy.manifests.plan import KEYS, KEYS_INSIDE, PORT, SCENARIO, Plan, join, listen
from deploy.security.roster import ROUTER, WORLD

SECRET = "secret.yaml"  # kubernetes: holds private keys
ETC = "/etc/disknav"  # systemd: the folder of a run lies in here
STALE = 10  # s without a sign of life: the process hangs
_TEMPLATES = Path(__file__).parent / "templates"
_CONFIG_INSIDE = "/config"
_SCRATCH = "/tmp"  # all that a container may write to, in memory
_ALIVE = f"{_SCRATCH}/alive"
# The main loop went round lately. Two tools of the system, no interpreter, no connection.
PROBE = f"test $(($(date +%s) - $(stat -c %Y {_ALIVE}))) -lt {STALE}"
_BUILD = (
    "docker build -t {image} -f Containerfile .     in a checkout of disknav: compiled, from nothing else"
)
_ACCOUNT = 65532  # of containers in a cluster: not root
_PICK = 'set -- $ROBOTS; shift "$INDEX"; exec disknav '  # the id at this pod's index
_HOMES = ("/home/", "/root/", "/run/user/")


def router_host(orchestrator: str, plan: Plan) -> str:
    """Name or address by which the fleet reaches its router."""
    if orchestrator == "compose":
        return ROUTER
    if orchestrator == "kubernetes":
        return f"{plan.name}-{ROUTER}"
    return plan.router.partition("/")[2].rpartition(":")[0].strip("[]")


def compose(plan: Plan) -> dict[str, str]:
    """Docker Compose: a service for each process, each with its own key only. Files by name.

    The user that runs this owns the keys, so the containers run as that user.
    """
    roles = (ROUTER, WORLD, *plan.robots)
    robots = [
        _filled(
            "compose-robot.yaml",
            role=role,
            command=_contained("compose", plan, role),
            keys=_mounted(plan, role),
        )
        for role in plan.robots
    ]
    names = sorted({name for role in roles for name in plan.files(role)})
    text = _filled(
        "compose.yaml",
        **_common(plan),
        user=f"{os.getuid()}:{os.getgid()}",
        probe=json.dumps(PROBE.replace("$", "$$")),  # Compose replaces $NAME by itself
        wait=f"{plan.wait:.0f}",
        router=json.dumps(listen(f"tls/0.0.0.0:{PORT}", KEYS_INSIDE)),
        router_keys=_mounted(plan, ROUTER),
        world=_contained("compose", plan, WORLD),
        world_keys=_mounted(plan, WORLD),
        scenario_inside=f"{_CONFIG_INSIDE}/{SCENARIO}",
        robots="".join(robots),
        secrets="\n".join(f"  {name}: {{file: ./{KEYS}/{name}}}" for name in names),
    )
    return {"compose.yaml": text, SCENARIO: plan.scenario}


def kubernetes(plan: Plan, keys: Mapping[str, bytes]) -> dict[str, str]:
    """Kubernetes: a Deployment of the router, a Job for the world, an indexed Job for the robots.

    `keys` are the files of the folder of keys. Files by name.
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
    """systemd: a unit each for router and world, a template for robots, a target of all. Files by name."""
    name, folder = plan.name, f"{ETC}/{plan.name}"
    units = [f"{name}-{role.replace('-', '@')}.service" for role in plan.robots]
    target = _filled(
        "systemd.target",
        **_common(plan),
        folder=folder,
        keys_folder=KEYS,
        wanted=" ".join([f"{name}-{ROUTER}.service", f"{name}-{WORLD}.service", *units]),
    )
    watched = "WatchdogSec=10"  # the main loop tells every second that it goes round
    router, world = listen(plan.router, "%d"), join(WORLD, plan.router, "%d", plan, f"%d/{SCENARIO}")
    robot = join("robot-%i", plan.router, "%d", plan, "")
    return {
        f"{name}.target": target,
        f"{name}-{ROUTER}.service": _service(plan, ROUTER, router, "Restart=always\nRestartSec=1"),
        # The fleet would go on from elsewhere than the robots are.
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
    """Homes are hidden, but for software that lies in one, whatever the modes of the folders above it."""
    there = [path for path in plan.software if path.startswith(_HOMES)]
    if not there:
        return "ProtectHome=yes"
    return "\n".join(["ProtectHome=tmpfs", *(f"BindReadOnlyPaths={_quoted(path)}" for path in there)])


def _quoted(path: str) -> str:
    """A path as systemd reads one word."""
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
    """The command line, after `disknav`, of the world or a robot in a container."""
    endpoint = f"tls/{router_host(orchestrator, plan)}:{PORT}"
    command = join(role, endpoint, KEYS_INSIDE, plan, f"{_CONFIG_INSIDE}/{SCENARIO}")
    return [*command, "--alive", _ALIVE]


def _contained(orchestrator: str, plan: Plan, role: str) -> str:
    return json.dumps(_member(orchestrator, plan, role))


def _mounted(plan: Plan, role: str) -> str:
    """Compose: the keys of one role, as a list of YAML."""
    return json.dumps([{"source": name, "target": f"{KEYS_INSIDE}/{name}"} for name in plan.files(role)])


def _items(plan: Plan, folders: Sequence[tuple[str, str]]) -> str:
    """Kubernetes: of the secret the keys of some roles, each under a folder, as a list of YAML."""
    return json.dumps(
        [{"key": name, "path": f"{folder}{name}"} for folder, role in folders for name in plan.files(role)]
    )


def _filled(template: str, **values: str) -> str:
    return Template((_TEMPLATES / template).read_text(encoding="utf-8")).substitute(values)
