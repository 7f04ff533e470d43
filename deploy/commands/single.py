"""`disknav robot | world | router`: the single processes, for other launchers."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer

from deploy.options import Mode

Router = Annotated[str, typer.Option(help="Endpoint of the router, e.g. tcp/127.0.0.1:7447.")]
Run = Annotated[str, typer.Option(help="Name of the run; all processes of a fleet share it.")]
DEFAULT_ROUTER = "tcp/127.0.0.1:7447"


def robot(
    robot_id: Annotated[int, typer.Argument(metavar="ID", help="The robot's id in the scenario.")],
    run: Run,
    router: Router = DEFAULT_ROUTER,
) -> None:
    """Run one robot; everything else it learns from the world.

    Example: disknav robot 3 --run demo --router tcp/10.0.0.1:7447
    """
    # A fresh interpreter: a robot carries neither this command line nor its libraries.
    os.execv(sys.executable, [sys.executable, "-m", "agents.process", router, run, str(robot_id)])


def world(
    scenario: Annotated[str, typer.Argument(help="A scenario file or a library name.")],
    run: Run,
    router: Router = DEFAULT_ROUTER,
    mode: Annotated[Mode, typer.Option(help="Who sets the pace: the robots or the wall clock.")] = "lockstep",
    seed: Annotated[int | None, typer.Option(help="Seed, over the scenario's.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="path.to.key=VALUE, over the file.")
    ] = None,
) -> None:
    """Run the world of a scenario: it waits for the robots, drives the clock and judges.

    Example: disknav world figure-1 --run demo
    """
    from deploy.load import load
    from protocol.connection import Connection
    from world.process import main

    loaded = load(scenario, setting or [], seed)
    raise typer.Exit(main(Connection(connect=(router,)), run, [loaded], mode == "lockstep"))


def router(
    listen: Annotated[
        str | None, typer.Option(help="Endpoint to listen on; the first free port from 7447 unless given.")
    ] = None,
    connect: Annotated[list[str] | None, typer.Option(help="Router of another host to link with.")] = None,
) -> None:
    """Run a router that relays between the processes of this host, and to routers of other hosts.

    Example: disknav router --listen tcp/0.0.0.0:7447 --connect tcp/10.0.0.2:7447
    """
    from deploy.router import main
    from protocol.connection import Connection

    endpoints = () if listen is None else (listen,)
    raise typer.Exit(main(Connection("router", connect=tuple(connect or ()), listen=endpoints)))
