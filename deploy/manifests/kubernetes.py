"""Kubernetes: a Deployment of the router, a Job for the world, an indexed Job for the robots."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from typing import Any

from deploy.manifests import container, pods
from deploy.manifests.container import CONFIG_INSIDE, json_text
from deploy.manifests.plan import KEYS_INSIDE, PORT, SCENARIO, Plan
from deploy.security.roster import ROUTER, WORLD

FLEET, SECRET = "fleet.yaml", "secret.yaml"
_HEAD = f"""\
Router, world and robots of the run {{run}}. {container.BUILD}
Then, with the image where the cluster finds it, in this folder:
  kubectl apply -f secret.yaml -f fleet.yaml
  kubectl wait --for=condition=complete --timeout=10m job/{{name}}-world
The job of the world completes if all arrived and nothing touched, else it fails; its log is the report."""
_SECRET_HEAD = "Private keys: whoever reads this file can take part in the run."
# An index is not an id: the list of ids, from which a pod takes the one at its index.
_PICK = 'set -- $ROBOTS; shift "$INDEX"; exec disknav '


def hosts(plan: Plan) -> tuple[str, ...]:
    """By which name the router is found."""
    return (f"{plan.name}-router",)


def kubernetes(plan: Plan, keys: Mapping[str, bytes]) -> dict[str, str]:
    """Files by name. `keys` are the files of the directory of keys."""
    objects = [_config(plan), _router_service(plan), _router(plan), _world(plan), _robots(plan)]
    fleet = {"apiVersion": "v1", "kind": "List", "items": objects}
    head = _HEAD.format(run=plan.roster.run, image=plan.image, name=plan.name)
    secret = {
        "apiVersion": "v1",
        "kind": "Secret",
        "metadata": pods.metadata(plan, "keys"),
        "type": "Opaque",
        "data": {name: b64encode(content).decode() for name, content in sorted(keys.items())},
    }
    return {FLEET: json_text(fleet, head), SECRET: json_text(secret, _SECRET_HEAD)}


def _config(plan: Plan) -> dict[str, Any]:
    return {
        "apiVersion": "v1",
        "kind": "ConfigMap",
        "metadata": pods.metadata(plan, "config"),
        "data": {SCENARIO: plan.scenario},
    }


def _router_service(plan: Plan) -> dict[str, Any]:
    return {
        "apiVersion": "v1",
        "kind": "Service",
        "metadata": pods.metadata(plan, ROUTER),
        "spec": {
            "selector": pods.labels(plan, ROUTER),
            "ports": [{"name": "zenoh", "port": PORT, "targetPort": "zenoh"}],
        },
    }


def _router(plan: Plan) -> dict[str, Any]:
    listening = {"tcpSocket": {"port": "zenoh"}, "periodSeconds": 5}
    running = {
        "name": ROUTER,
        "image": plan.image,
        "command": ["disknav", *container.ROUTER_COMMAND],
        "ports": [{"name": "zenoh", "containerPort": PORT}],
        "startupProbe": {**listening, "failureThreshold": 30},
        "livenessProbe": listening,
        "volumeMounts": [pods.mount("keys", KEYS_INSIDE), pods.SCRATCH],
    }
    return {
        "apiVersion": "apps/v1",
        "kind": "Deployment",
        "metadata": pods.metadata(plan, ROUTER),
        "spec": {
            "replicas": 1,
            "selector": {"matchLabels": pods.labels(plan, ROUTER)},
            "template": pods.pod(plan, ROUTER, running, pods.keys(plan, ROUTER), restart="Always"),
        },
    }


def _world(plan: Plan) -> dict[str, Any]:
    command = container.join(plan, WORLD, _endpoint(plan))
    running = {
        "name": WORLD,
        "image": plan.image,
        "command": ["disknav", *command],
        **pods.health(plan),
        "volumeMounts": [
            pods.mount("config", CONFIG_INSIDE),
            pods.mount("keys", KEYS_INSIDE),
            pods.SCRATCH,
        ],
    }
    # A world that has gone cannot be replaced in the middle of a run.
    template = pods.pod(plan, WORLD, running, pods.keys(plan, WORLD), restart="Never")
    return pods.job(plan, WORLD, {"backoffLimit": 0, "template": template})


def _robots(plan: Plan) -> dict[str, Any]:
    ids = [str(robot) for robot in plan.roster.robots]
    command = container.join(plan, "robot-$1", _endpoint(plan))
    running = {
        "name": "robot",
        "image": plan.image,
        "command": ["/bin/sh", "-c", _PICK + " ".join(command)],
        "env": [
            {"name": "ROBOTS", "value": " ".join(ids)},
            {"name": "INDEX", "valueFrom": {"fieldRef": {"fieldPath": pods.INDEX}}},
        ],
        **pods.health(plan),
        # Each sees the folder of its own index, with its own keys alone.
        "volumeMounts": [{**pods.mount("keys", KEYS_INSIDE), "subPathExpr": "$(INDEX)"}, pods.SCRATCH],
    }
    return pods.job(
        plan,
        "robots",
        {
            "completions": len(ids),
            "parallelism": len(ids),
            "completionMode": "Indexed",
            "backoffLimit": 3 * len(ids),
            "template": pods.pod(
                plan, "robot", running, pods.indexed_keys(plan, plan.robots), restart="OnFailure"
            ),
        },
    )


def _endpoint(plan: Plan) -> str:
    return f"tls/{hosts(plan)[0]}:{PORT}"
