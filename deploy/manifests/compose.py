"""Docker Compose: a service for each process, each with its own key only."""

from __future__ import annotations

import os
from typing import Any

from deploy.manifests import container
from deploy.manifests.json_text import json_text
from deploy.manifests.plan import KEYS, KEYS_INSIDE, PORT, ROUTER_CONFIG, SCENARIO, Plan, zenohd_config
from deploy.security.roster import ROUTER, WORLD

HOSTS = (ROUTER,)  # by which name the router is found
_FILE = "compose.yaml"
_ENDPOINT = f"tls/{ROUTER}:{PORT}"
_HEAD = """\
Router, world and robots of the run {run}. In this folder:
  docker build -t {image} .
  docker compose up --abort-on-container-failure
The keys are mounted as they are here, so the containers run as their owner."""
_DOCKERFILE = """\
# DISKNAV is whatever pip can install: a name, a wheel beside this file, or an address.
FROM python:3.12-slim
ARG DISKNAV=disknav
COPY Dockerfile *.whl /tmp/
WORKDIR /tmp
RUN pip install --no-cache-dir "${DISKNAV}[secure]" && rm -f /tmp/*.whl
USER 65532:65532
WORKDIR /
ENTRYPOINT ["disknav"]
"""


def compose(plan: Plan) -> dict[str, str]:
    """Files by name. The user that runs this owns the keys, so the containers run as that user."""
    members = (WORLD, *plan.robots)
    content = {
        "name": plan.name,
        "services": {ROUTER: _router(plan), **{role: _member(plan, role) for role in members}},
        "networks": {"fleet": {}},
        "configs": {
            "router": {"file": f"./{ROUTER_CONFIG}"},
            "scenario": {"file": f"./{SCENARIO}"},
        },
        "secrets": {
            name: {"file": f"./{KEYS}/{name}"}
            for name in sorted({name for role in (ROUTER, *members) for name in plan.files(role)})
        },
    }
    head = _HEAD.format(run=plan.roster.run, image=plan.image)
    return {
        _FILE: json_text(content, head),
        ROUTER_CONFIG: zenohd_config(plan.roster),
        SCENARIO: plan.scenario,
        "Dockerfile": _DOCKERFILE,
    }


def _router(plan: Plan) -> dict[str, Any]:
    return {
        **_service(plan, ROUTER),
        "image": container.ZENOH_IMAGE,
        "entrypoint": container.ROUTER_COMMAND,
        "configs": [{"source": "router", "target": container.ROUTER_CONFIG_INSIDE}],
        "healthcheck": {
            "test": ["CMD-SHELL", f"nc -z 127.0.0.1 {PORT}"],
            "interval": "5s",
            "timeout": "2s",
            "retries": 5,
        },
    }


def _member(plan: Plan, role: str) -> dict[str, Any]:
    service = {
        **_service(plan, role),
        "image": plan.image,
        "command": container.join(plan, role, _ENDPOINT),
        "depends_on": {ROUTER: {"condition": "service_started"}},
        "healthcheck": {
            "test": ["CMD", "disknav", *container.probe(role, _ENDPOINT)],
            "interval": "15s",
            "timeout": "10s",
            "retries": 3,
            "start_period": "30s",
        },
    }
    if role == WORLD:
        return {**service, "configs": [{"source": "scenario", "target": container.SCENARIO_INSIDE}]}
    return {**service, "restart": "on-failure"}


def _service(plan: Plan, role: str) -> dict[str, Any]:
    """What all have in common: no privileges, nothing to write to, no keys but their own."""
    return {
        "user": f"{os.getuid()}:{os.getgid()}",
        "networks": ["fleet"],
        "read_only": True,
        "cap_drop": ["ALL"],
        "security_opt": ["no-new-privileges:true"],
        "stop_grace_period": "5s",
        "secrets": [{"source": name, "target": f"{KEYS_INSIDE}/{name}"} for name in plan.files(role)],
    }
