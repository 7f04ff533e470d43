"""The processes of a fleet as a table, one row each, which is named by the role of its process."""

from __future__ import annotations

from pathlib import Path

from deploy.processes.spawn import Process
from deploy.security.roster import ROUTER, WORLD, robot_role, router_role
from protocol.bus.connection import Connection
from protocol.scenario.model import Scenario
from world.shell.failure_detector import GATHERING

RECORDER = "recorder"
_ROUTING = "deploy.processes.router:main"
_LINKING = 8.0  # s for the routers of all hosts to link


def router(
    connection: Connection,
    restarts: int = 0,
    host: str = "",
    *,
    vital: bool = True,
) -> Process:
    """The router, which reports its endpoint; with several hosts once it is linked with the others.

    With several hosts only the router of the world's host is `vital`: without another one, only the robots
    behind it are lost.
    """
    name, arguments = router_role(host), (connection, _LINKING if host else 0.0)
    return Process(name, _ROUTING, arguments, vital, restarts, reports=True)


def world(
    connection: Connection,
    run: str,
    scenario: Scenario,
    lockstep: bool,
    gathering: float = GATHERING,
    speed: float = 0.0,
    restarts: int = 0,
    checkpoint: Path | None = None,
    returns: int = 0,
) -> Process:
    """The world of a run, which reports its result as JSON.

    `restarts` is that of the robots' rows; with a `checkpoint` the world is restarted as often. `returns`
    counts the times that each robot is waited for, if these are more.
    """
    arguments = (connection, run, scenario, lockstep, gathering, speed, max(restarts, returns), checkpoint)
    again = 0 if checkpoint is None else restarts
    entry = "world.process:supervised"
    return Process(WORLD, entry, arguments, True, again, reports=True)


def robot(
    connection: Connection,
    run: str,
    identity: int,
    restarts: int = 0,
    core: int | None = None,
) -> Process:
    """One robot; the fleet goes on without it."""
    name, arguments = robot_role(identity), (connection, run, identity)
    return Process(name, "agents.process:main", arguments, restarts=restarts, core=core)


def is_router(name: str) -> bool:
    """Whether this is the name of a router's row."""
    return name == ROUTER or name.startswith(f"{ROUTER}-")


def outlasts(name: str) -> bool:
    """Whether this process is needed until the end, also after the last run."""
    return name == RECORDER or is_router(name)


def robot_of(name: str) -> int | None:
    """Id of the robot in a row of this name; None for other rows."""
    kind, _, identity = name.rpartition("-")
    return int(identity) if kind == "robot" and identity.isdecimal() else None
