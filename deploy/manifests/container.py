"""What is the same in every container orchestrator: image, places inside a container, commands, probe."""

from __future__ import annotations

import json
from typing import Any

from deploy.manifests import plan
from deploy.manifests.plan import KEYS_INSIDE, PORT, SCENARIO, Plan

CONFIG_INSIDE = "/config"
SCENARIO_INSIDE = f"{CONFIG_INSIDE}/{SCENARIO}"
ROUTER_COMMAND = ["router", "--listen", f"tls/0.0.0.0:{PORT}", "--secure", KEYS_INSIDE]
SCRATCH = "/tmp"  # all that a container may write to, in memory
_ALIVE = f"{SCRATCH}/alive"
STALE = 10  # s without a sign of life: a hung interpreter; whoever lost its world ends by itself
# The main loop went round lately. Two tools of the system, no interpreter, no connection.
PROBE = f"test $(($(date +%s) - $(stat -c %Y {_ALIVE}))) -lt {STALE}"
BUILD = "docker build -t {image} -f Containerfile .     in a checkout of disknav: compiled, from nothing else"


def join(of: Plan, role: str, endpoint: str) -> list[str]:
    """The command line, after `disknav`, of the world or a robot."""
    return [*plan.join(role, endpoint, KEYS_INSIDE, of, SCENARIO_INSIDE), "--alive", _ALIVE]


def json_text(document: Any, head: str) -> str:
    """JSON for people: indented, with a comment on top, which YAML, a superset, allows for."""
    comment = "".join(f"# {line}\n" for line in head.splitlines())
    return f"{comment}{json.dumps(document, indent=2, ensure_ascii=False)}\n"
