"""What is to run, whatever runs it."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import deploy
from deploy.run.options import Mode
from deploy.security.roster import ROSTER, Roster, robot_role
from protocol.bus.connection import AUTHORITY, certificate_file, key_file

SCENARIO = "scenario.toml"
KEYS = "keys"  # the folder of keys beside the files
PORT = 7447
IMAGE = "localhost/disknav"  # nobody else can offer one under this name
KEYS_INSIDE = "/keys"  # where a container finds the few that are its own


@dataclass(frozen=True)
class Plan:
    """A run, its scenario, and what an orchestrator starts."""

    roster: Roster
    scenario: str  # TOML
    mode: Mode = "realtime"
    image: str = IMAGE  # container image with this software
    command: str = "/usr/local/bin/disknav"  # where this software is on a host
    software: tuple[str, ...] = ()  # folders on a host without which that does not run
    router: str = f"tls/127.0.0.1:{PORT}"  # where hosts find the router
    wait: float = 300.0  # s that router, world and robots may take to be there, in any order

    @property
    def name(self) -> str:
        """Name of everything that belongs to this run: letters, digits and '-' only."""
        return f"disknav-{self.roster.run}".lower().replace("_", "-").rstrip("-")

    @property
    def robots(self) -> tuple[str, ...]:
        """Roles of all robots; those that come by orders wait for their disks."""
        return tuple(robot_role(robot) for robot in self.roster.robots)

    def files(self, role: str) -> tuple[str, ...]:
        """All of the keys that a role needs."""
        return (AUTHORITY, ROSTER, certificate_file(role), key_file(role))


def join(role: str, router: str, keys: str, plan: Plan, scenario: str) -> list[str]:
    """The command line, after `disknav`, of the world or a robot."""
    connection = ["--router", router, "--secure", keys, "--wait", f"{plan.wait:g}"]
    if role.startswith("robot-"):
        return ["node", "robot", role.removeprefix("robot-"), *connection]
    return ["node", "world", scenario, "--mode", plan.mode, *connection]


def listen(endpoint: str, keys: str) -> list[str]:
    """The command line, after `disknav`, of the router."""
    return ["node", "router", "--listen", endpoint, "--secure", keys]


def installation() -> tuple[str, ...]:
    """Folders of this host without which this software does not run: environment, interpreter, sources."""
    folders = (sys.prefix, sys.base_prefix, *(str(Path(each).parent) for each in deploy.__path__))
    return tuple(dict.fromkeys(str(Path(folder).resolve()) for folder in folders))
