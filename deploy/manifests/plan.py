"""What is to run, whatever runs it."""

from __future__ import annotations

from dataclasses import dataclass

from deploy.processes.router_config import router_config
from deploy.run.options import Mode
from deploy.security.access import access_control
from deploy.security.roster import ROSTER, ROUTER, Roster, robot_role
from protocol.bus.connection import Connection
from protocol.bus.credentials import AUTHORITY, Credentials, certificate_file, key_file

SCENARIO = "scenario.toml"
ROUTER_CONFIG = "router.json5"
KEYS = "keys"  # the folder of keys beside the files
PORT = 7447
KEYS_INSIDE = "/keys"  # where a container finds the few that are its own


@dataclass(frozen=True)
class Plan:
    """A run, its scenario, and what an orchestrator starts."""

    roster: Roster
    scenario: str  # TOML
    mode: Mode = "realtime"
    image: str = "disknav"  # container image with this software
    command: str = "/usr/local/bin/disknav"  # where this software is on a host
    router: str = f"tls/127.0.0.1:{PORT}"  # where hosts find the router

    @property
    def name(self) -> str:
        """Name of everything that belongs to this run: letters, digits and '-' only."""
        return f"disknav-{self.roster.run}".lower().replace("_", "-").rstrip("-")

    @property
    def robots(self) -> tuple[str, ...]:
        """Roles of the robots."""
        return tuple(map(robot_role, self.roster.robots))

    def files(self, role: str) -> tuple[str, ...]:
        """All of the keys that a role needs."""
        return (AUTHORITY, ROSTER, certificate_file(role), key_file(role))


def join(role: str, router: str, keys: str, mode: Mode, scenario: str) -> list[str]:
    """The command line, after `disknav`, of the world or a robot."""
    connection = ["--router", router, "--secure", keys]
    if role.startswith("robot-"):
        return ["robot", role.removeprefix("robot-"), *connection]
    return ["world", scenario, "--mode", mode, *connection]


def probe(role: str, router: str, keys: str) -> list[str]:
    """The command line, after `disknav`, that tells whether a role is well."""
    return ["probe", role, "--router", router, "--secure", keys]


def zenohd_config(roster: Roster) -> str:
    """Configuration of the stock router in a container, with the rules of this run."""
    files = Credentials(
        *(f"{KEYS_INSIDE}/{name}" for name in (AUTHORITY, certificate_file(ROUTER), key_file(ROUTER)))
    )
    connection = Connection("router", credentials=files, access=access_control(roster))
    return router_config(connection, f"tls/0.0.0.0:{PORT}")
