"""Parts of Kubernetes objects that router, world and robots share."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

from deploy.manifests import container
from deploy.manifests.plan import Plan

INDEX = "metadata.annotations['batch.kubernetes.io/job-completion-index']"
_USER = 65532  # anybody but root
SCRATCH = {"name": "scratch", "mountPath": container.SCRATCH}
_MODE = 0o400  # fsGroup adds reading by the group; the owner is root


def labels(plan: Plan, part: str) -> dict[str, str]:
    """What tells the pods of one part of a run."""
    return {
        "app.kubernetes.io/name": "disknav",
        "app.kubernetes.io/instance": plan.name,
        "app.kubernetes.io/component": part,
    }


def metadata(plan: Plan, part: str) -> dict[str, Any]:
    """Name and labels of an object."""
    return {"name": f"{plan.name}-{part}", "labels": labels(plan, part)}


def mount(volume: str, path: str) -> dict[str, Any]:
    """A volume that is only read."""
    return {"name": volume, "mountPath": path, "readOnly": True}


def keys(plan: Plan, role: str) -> dict[str, Any]:
    """The keys of one role, of all in the secret."""
    items = [{"key": name, "path": name} for name in plan.files(role)]
    return _secret(plan, items)


def indexed_keys(plan: Plan, roles: Sequence[str]) -> dict[str, Any]:
    """A folder of keys for each index of a Job."""
    items = [
        {"key": name, "path": f"{index}/{name}"}
        for index, role in enumerate(roles)
        for name in plan.files(role)
    ]
    return _secret(plan, items)


def health(plan: Plan) -> dict[str, Any]:
    """Started again when its main loop has not come round for a while; nobody asks a robot for service, so
    nothing depends on its being ready."""
    probe = {"exec": {"command": ["/bin/sh", "-c", container.PROBE]}, "periodSeconds": 5, "timeoutSeconds": 2}
    return {
        "startupProbe": {**probe, "failureThreshold": ceil(plan.wait / 5) + 6},
        "livenessProbe": {**probe, "failureThreshold": 3},
    }


def pod(
    plan: Plan, part: str, running: dict[str, Any], secret: dict[str, Any], *, restart: str
) -> dict[str, Any]:
    """A pod of one container that can do nothing but compute and connect."""
    confined = {
        "allowPrivilegeEscalation": False,
        "readOnlyRootFilesystem": True,
        "capabilities": {"drop": ["ALL"]},
    }
    resources = {
        "requests": {"cpu": "100m", "memory": "64Mi"},
        "limits": {"memory": "256Mi"},
    }
    config = {"name": "config", "configMap": {"name": f"{plan.name}-config"}}
    return {
        "metadata": {"labels": labels(plan, part)},
        "spec": {
            "restartPolicy": restart,
            "automountServiceAccountToken": False,
            "terminationGracePeriodSeconds": 5,
            "securityContext": {
                "runAsNonRoot": True,
                "runAsUser": _USER,
                "runAsGroup": _USER,
                "fsGroup": _USER,
                "seccompProfile": {"type": "RuntimeDefault"},
            },
            "containers": [{**running, "securityContext": confined, "resources": resources}],
            "volumes": [secret, config, {"name": "scratch", "emptyDir": {"medium": "Memory"}}],
        },
    }


def job(plan: Plan, part: str, spec: dict[str, Any]) -> dict[str, Any]:
    """A Job that stays for an hour after its end, for its log."""
    return {
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": metadata(plan, part),
        "spec": {**spec, "ttlSecondsAfterFinished": 3600},
    }


def _secret(plan: Plan, items: list[dict[str, str]]) -> dict[str, Any]:
    return {
        "name": "keys",
        "secret": {
            "secretName": f"{plan.name}-keys",
            "defaultMode": _MODE,
            "items": items,
            "optional": False,
        },
    }
