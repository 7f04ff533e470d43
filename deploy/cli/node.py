"""`disknav node`: single processes of a run, for other launchers."""

from __future__ import annotations

import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from deploy.cli import options
from deploy.output import EXIT_ARRIVED, EXIT_INVALID, check_target
from deploy.security.membership import KeyRing
from deploy.security.roster import WORLD, robot_role
from protocol.errors import UsageError
from protocol.keys import robot_key
from protocol.process.log import LOG, begin, set_process_title
from protocol.process.signals import STOP
from protocol.scenario.body import ros_name

WaitSeconds = Annotated[
    float, typer.Option(min=1.0, help="Seconds to wait for the router and the other processes.")
]
Alive = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Touch this file every second while the main loop runs, for probes."),
]
_WAIT = 60.0
app = typer.Typer(
    name="node", help="Run single processes, for systemd, containers or a manual start.", no_args_is_help=True
)


@app.command()
def robot(
    robot_id: Annotated[int, typer.Argument(metavar="ID", help="The robot's id in the scenario.")],
    run: options.RunName = None,
    router: options.Router = None,
    secure: options.Secure = None,
    wait: WaitSeconds = _WAIT,
    alive: Alive = None,
    base: Annotated[
        Literal["ros2"] | None, typer.Option(help="Drive an external base by ROS 2 messages over zenoh.")
    ] = None,
    namespace: Annotated[
        str | None,
        typer.Option(help="Namespace of the base's topics; default: the scenario's, else /bot and the id."),
    ] = None,
    log: options.LogFile = None,
) -> None:
    """Run one robot; it receives its scenario from the world.

    Examples: disknav node robot 3 --run demo --router tcp/10.0.0.1:7447;
    disknav node robot 1 --run yard --base ros2 --namespace /bot1
    """
    if namespace is not None and base is None:
        raise UsageError("--namespace is for an external base: add --base ros2")
    if base is not None:
        options.refuse_bases(secure)
    namespace = None if namespace is None else ros_name(namespace)
    membership = KeyRing(secure)
    role, name = robot_role(robot_id), membership.named_run(run)
    robot_key(name, robot_id, "join")  # refuses an invalid id
    # Errors in its files are reported here,
    (endpoint,) = membership.client(role, (router,)).connect
    begin(f"robot-{robot_id}", name, log)  # as are those of its log
    # A fresh interpreter, without the libraries of this command line. -P: without the working directory,
    # which may hold another folder `agents`.
    files = ["" if file is None else str(file.absolute()) for file in (secure, alive, log)]
    outside = [base or "", namespace or ""]
    arguments = [endpoint, name, str(robot_id), str(wait), *files, *outside]
    with STOP.held():
        STOP.check()
        os.execv(sys.executable, [sys.executable, "-P", "-m", "agents.process", *arguments])


@app.command()
def world(
    scenario: options.Scenario,
    run: options.RunName = None,
    router: options.Router = None,
    mode: options.ModeOption = "lockstep",
    seed: options.Seed = None,
    setting: options.SettingOptions = None,
    secure: options.Secure = None,
    plant: Annotated[
        str | None, typer.Option(help="Plant: integrator, mujoco, or external for external bases.")
    ] = None,
    checkpoint: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Checkpoint; continue from it if it exists.")
    ] = None,
    wait: WaitSeconds = _WAIT,
    alive: Alive = None,
    log: options.LogFile = None,
) -> None:
    """Run the world of a scenario: wait for the robots, keep the clock, judge, and print the report.

    Example: disknav node world figure-1 --run demo --checkpoint demo.checkpoint > report.json

    Exit status: 0 all arrived and nothing touched, 1 ended otherwise, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.library.load import load
    from deploy.run.result import exit_status
    from protocol.bus.bus import heartbeat
    from world.process import OVER, main
    from world.shell.checkpoint import Checkpoint
    from world.shell.failure_detector import RETURNS

    check_target(checkpoint, "write the checkpoint", scenario)
    membership = KeyRing(secure)
    settings = [*(setting or []), *([] if plant is None else [f"world.plant={plant}"])]
    loaded = load(scenario, settings, seed)
    if loaded.has_topics:
        options.refuse_bases(secure)
    connection = membership.client(WORLD, (router,), timeout=wait)
    run_name = membership.named_run(run)
    set_process_title("world", run_name)
    begin("world", run_name, log, alone=True)
    if checkpoint is not None and not os.path.lexists(checkpoint):
        Checkpoint.create(checkpoint)
    verdicts: list[int] = []

    def on_report(report: dict[str, Any]) -> None:
        sys.stdout.write(json.dumps(report, indent=2) + "\n")
        verdicts.append(exit_status(report))

    status = main(
        connection,
        run_name,
        loaded,
        mode == "lockstep",
        gathering=wait,
        restarts=RETURNS,
        checkpoint=checkpoint,
        on_report=on_report,
        beat=heartbeat(alive),
    )
    failed = EXIT_INVALID if status == OVER else status
    raise typer.Exit(failed or (verdicts[-1] if verdicts else EXIT_ARRIVED))


@app.command()
def router(
    listen: Annotated[
        str | None, typer.Option(help="Endpoint to listen on; by default the first free port from 7447.")
    ] = None,
    connect: Annotated[
        list[str] | None, typer.Option(help="Endpoint of another host's router to link with; repeatable.")
    ] = None,
    secure: options.Secure = None,
    host: Annotated[str, typer.Option(help="Name of this host, if the keys are for several.")] = "",
    admin: Annotated[
        bool, typer.Option("--admin", help="Show connections and declarations in zenoh's admin space.")
    ] = False,
    log: options.LogFile = None,
    print_config: Annotated[
        bool, typer.Option("--print-config", help="Print the equivalent configuration for zenohd, and end.")
    ] = False,
) -> None:
    """Run a router for the processes of this host, linked to routers of other hosts.

    Examples: disknav node router --listen tcp/0.0.0.0:7447 --connect tcp/10.0.0.2:7447;
    by zenoh's own router: disknav node router --secure keys --print-config > r.json5; zenohd -c r.json5
    """
    from deploy.processes.router import main, router_config

    if secure is None:
        options.refuse({"--host": host or None}, "it chooses a router's key: add --secure DIR")
    membership = KeyRing(secure)
    plain = membership.router(() if listen is None else (listen,), connect or (), host)
    connection = replace(plain, admin=admin)
    if print_config:
        sys.stdout.write(router_config(connection, membership.endpoint(None)))
        return
    run = membership.run(None) or ""
    set_process_title("router", run)
    begin("router", run, log, alone=True)
    raise typer.Exit(main(connection, ready=_print))


@app.command(hidden=True)
def host(run: Annotated[str, typer.Option(help="Name of the run, for `ps`.")] = "") -> None:
    """Start processes for a launcher on another host, over standard input and output."""
    from deploy.processes.spawn import environment

    # A fresh interpreter, so that forked processes are without the libraries of this command line.
    # -P: without the working directory.
    call = [sys.executable, "-P", "-m", "deploy.processes.hosts.remote", run]
    os.execve(sys.executable, call, environment())


def _print(endpoint: str) -> None:
    from protocol.bus.bus import heartbeat

    LOG.warning(f"listening on {endpoint}")
    if (beat := heartbeat(None)) is not None:
        beat(0.0)
