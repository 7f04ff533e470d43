"""What is the same in every container orchestrator: images, places inside a container, commands."""

from __future__ import annotations

from deploy.manifests import plan
from deploy.manifests.plan import KEYS_INSIDE, ROUTER_CONFIG, SCENARIO, Plan

ZENOH_IMAGE = "eclipse/zenoh:1.10.2"
CONFIG_INSIDE = "/config"
ROUTER_CONFIG_INSIDE = f"{CONFIG_INSIDE}/{ROUTER_CONFIG}"
SCENARIO_INSIDE = f"{CONFIG_INSIDE}/{SCENARIO}"
ROUTER_COMMAND = ["/zenohd", "-c", ROUTER_CONFIG_INSIDE]


def join(of: Plan, role: str, endpoint: str) -> list[str]:
    """The command line, after `disknav`, of the world or a robot."""
    return plan.join(role, endpoint, KEYS_INSIDE, of.mode, SCENARIO_INSIDE)


def probe(role: str, endpoint: str) -> list[str]:
    """The command line, after `disknav`, that tells whether a role is well."""
    return plan.probe(role, endpoint, KEYS_INSIDE)
