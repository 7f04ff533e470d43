"""`disknav serve`: a fleet that stays up until it is stopped."""

from __future__ import annotations

from typing import Annotated

import typer

from deploy.commands import options
from deploy.output.json_output import is_standard_output
from deploy.run.options import RunOptions, restarts
from deploy.run.outcome.result import served_status, show
from deploy.security.membership import Membership
from protocol.keys import checked_run
from protocol.process.log import LAUNCHER, begin

_RESTARTS = "on-failure:1000"


def serve(
    scenario: options.Scenario,
    name: Annotated[
        str | None,
        typer.Option("--run", metavar="NAME", help="Name of the run; the scenario's unless given."),
    ] = None,
    seed: options.Seed = None,
    setting: options.Settings = None,
    mode: options.ModeOption = "realtime",
    realtime_priority: options.RealtimePriority = False,
    speed: Annotated[
        float | None,
        typer.Option(min=0.0, help="Simulated seconds per second in lock-step; 1 unless given."),
    ] = None,
    listen: Annotated[
        str | None, typer.Option(help="Endpoint of the router; port 7447 on the loopback unless given.")
    ] = None,
    router: options.RouterThere = None,
    secure: options.Secure = None,
    record: options.Record = None,
    rotate: options.Rotate = None,
    json_file: options.Json = None,
    web: options.Web = False,
    restart: Annotated[
        str,
        typer.Option(
            metavar="POLICY", help="A process that fails is started again: never, or on-failure[:N]."
        ),
    ] = _RESTARTS,
    log: options.Log = None,
    quiet: options.Quiet = False,
) -> None:
    """Keep a fleet up until Ctrl-C; robots go where [b]disknav goal[/b] sends them.

    Example: disknav serve swap-6 --run yard; in another terminal: disknav goal yard 3 0.1 -0.05

    Exit status: 0 stopped and nothing touched, 1 something touched, 2 invalid, 3 fault, or the fleet died.
    """
    from deploy.library.load import load
    from deploy.run.execute import Extras, execute
    from deploy.telemetry.recording.parts import rotation

    options.refuse_idle(record, rotate, mode, speed)
    if router is not None:
        options.refuse({"--listen": listen}, "--router names a router that is there, and starts none")
    loaded = load(scenario, [*(setting or []), "time.endless=true"], seed)
    if loaded.is_external:
        options.refuse_bases(secure)
    membership = Membership(secure)
    run = membership.run(None if name is None else checked_run(name)) or checked_run(loaded.name)
    endpoint = membership.endpoint(router or listen or membership.default_router)
    how = RunOptions(
        mode=mode,
        router=None if router is None else endpoint,
        listen=endpoint if router is None else None,
        run=run,
        secure=secure,
        speed=0.0 if mode == "realtime" else 1.0 if speed is None else speed,
        restarts=restarts(restart),
        log=log,
        rotation=rotation(rotate or []),
        realtime_priority=realtime_priority,
    )
    begin(LAUNCHER, run, log)
    silent = quiet or is_standard_output(json_file)
    if not silent:
        typer.echo(f"run {run} at {endpoint}; Ctrl-C stops it", err=True)
    extras, tell = Extras(record=record, web=web, json=json_file), (lambda _: None) if silent else show
    result = execute(loaded, how, extras, quiet=silent, tell=tell)
    raise typer.Exit(served_status(result))
