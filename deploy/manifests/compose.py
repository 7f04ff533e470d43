"""Docker Compose: a service for each process, each with its own key only."""

from __future__ import annotations

import os
from typing import Any

from deploy.manifests import container
from deploy.manifests.container import json_text
from deploy.manifests.plan import KEYS, KEYS_INSIDE, PORT, SCENARIO, Plan
from deploy.security.roster import ROUTER, WORLD

HOSTS = (ROUTER,)  # by which name the router is found
_FILE = "compose.yaml"
_ENDPOINT = f"tls/{ROUTER}:{PORT}"
_HEAD = f"""\
Router, world and robots of the run {{run}}. {container.BUILD}
Then, in this folder; the last status is 0 if all arrived and nothing touched:
  docker compose up --detach && docker compose wait world
  docker compose logs world && docker compose down
The keys are mounted as they are here, so the containers run as their owner."""


def compose(plan: Plan) -> dict[str, str]:
    """Files by name. The user that runs this owns the keys, so the containers run as that user."""
    members = (WORLD, *plan.robots)
    content = {
        "name": plan.name,
        "services": {ROUTER: _router(plan), **{role: _member(plan, role) for role in members}},
        "networks": {"fleet": {}},
        "secrets": {
            name: {"file": f"./{KEYS}/{name}"}
            for name in sorted({name for role in (ROUTER, *members) for name in plan.files(role)})
        },
    }
    head = _HEAD.format(run=plan.roster.run, image=plan.image)
    return {_FILE: json_text(content, head), SCENARIO: plan.scenario}


def _router(plan: Plan) -> dict[str, Any]:
    return {
        **_service(plan, ROUTER, container.ROUTER_COMMAND),
        "restart": "on-failure",
        "healthcheck": _healthcheck(f"bash -c '</dev/tcp/127.0.0.1/{PORT}'", 5.0),
    }


def _member(plan: Plan, role: str) -> dict[str, Any]:
    service = {
        **_service(plan, role, container.join(plan, role, _ENDPOINT)),
        "healthcheck": _healthcheck(container.PROBE, plan.wait),
    }
    if role == WORLD:  # one that has gone cannot be replaced in the middle of a run
        return {**service, "volumes": [f"./{SCENARIO}:{container.SCENARIO_INSIDE}:ro"]}
    return {**service, "restart": "on-failure"}


def _healthcheck(command: str, start: float) -> dict[str, Any]:
    return {
        "test": ["CMD-SHELL", command],
        "interval": "5s",
        "timeout": "2s",
        "retries": 3,
        "start_period": f"{start:.0f}s",
    }


def _service(plan: Plan, role: str, command: list[str]) -> dict[str, Any]:
    """What all have in common: no privileges, nothing to write to, no keys but their own."""
    return {
        "image": plan.image,
        "command": command,
        "user": f"{os.getuid()}:{os.getgid()}",
        "networks": ["fleet"],
        "read_only": True,
        "tmpfs": [container.SCRATCH],
        "cap_drop": ["ALL"],
        "security_opt": ["no-new-privileges:true"],
        "stop_grace_period": "5s",
        "secrets": [{"source": name, "target": f"{KEYS_INSIDE}/{name}"} for name in plan.files(role)],
    }
