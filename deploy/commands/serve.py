"""`disknav serve`: a fleet that stays up until it is stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deploy.output.exit_status import EXIT_ARRIVED, EXIT_OTHERWISE
from deploy.output.json_output import is_standard_output
from deploy.run.options import Mode, RunOptions, restarts
from deploy.run.result import table
from deploy.security.membership import Membership
from protocol.keys import checked_run

_RESTARTS = "on-failure:1000"


def serve(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file (TOML), or a library name such as figure-1.")
    ],
    name: Annotated[
        str | None, typer.Option("--run", help="Name of the run; the scenario's unless given.")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Seed, over the scenario's.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="path.to.key=VALUE, over the file.")
    ] = None,
    mode: Annotated[Mode, typer.Option(help="Who sets the pace: the robots or the wall clock.")] = "realtime",
    speed: Annotated[float, typer.Option(min=0.0, help="Simulated seconds per second in lock-step.")] = 1.0,
    listen: Annotated[
        str | None, typer.Option(help="Endpoint of the router; port 7447 of this host unless given.")
    ] = None,
    router: Annotated[str | None, typer.Option(help="Use the router at this endpoint; start none.")] = None,
    secure: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Certificates and access rules from `disknav keys new DIR`."),
    ] = None,
    record: Annotated[
        Path | None, typer.Option(help="Record everything that crosses the network (MCAP).")
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the result; '-' for standard output.")
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve a live page; its address is printed.")] = False,
    restart: Annotated[
        str,
        typer.Option(
            metavar="POLICY", help="A process that fails is started again: never, or on-failure[:N]."
        ),
    ] = _RESTARTS,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no table.")] = False,
) -> None:
    """Keep a fleet up until Ctrl-C; robots go where [b]disknav goal[/b] sends them.

    Example: disknav serve swap-6 --run yard; in another terminal: disknav goal yard 3 0.1 -0.05

    Exit status: 0 stopped and nothing touched, 1 something touched, 2 invalid, 3 fault.
    """
    from deploy.library.load import load
    from deploy.run.execute import Extras, execute

    loaded = load(scenario, [*(setting or []), "time.endless=true"], seed)
    membership = Membership(secure)
    run = membership.run(None if name is None else checked_run(name)) or checked_run(loaded.name)
    endpoint = listen if listen is not None or router is not None else membership.default_router
    options = RunOptions(
        mode=mode,
        router=router,
        listen=endpoint,
        run=run,
        secure=secure,
        speed=speed if mode == "lockstep" else 0.0,
        restarts=restarts(restart),
    )
    silent = quiet or is_standard_output(json_file)
    if not silent:
        typer.echo(f"run {run} at {router or endpoint}; Ctrl-C stops it", err=True)
    result = execute(loaded, options, Extras(record=record, web=web, json=json_file), quiet=silent)
    if not silent:
        from rich.console import Console

        Console(soft_wrap=True).print(table(result))
    raise typer.Exit(EXIT_OTHERWISE if result["collisions"] else EXIT_ARRIVED)
