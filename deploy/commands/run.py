"""`disknav run`: a scenario from start to verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deploy.commands import options
from deploy.output.json_output import is_standard_output
from deploy.run.options import RESTARTS, RunOptions, Transport, fresh_run_name, restarts
from deploy.run.outcome.result import exit_status, show
from deploy.security.membership import Membership
from protocol.keys import checked_run
from protocol.process.log import LAUNCHER, begin


def run(
    scenario: options.Scenario,
    seed: options.Seed = None,
    setting: options.Settings = None,
    transport: Annotated[
        Transport, typer.Option(help="Through a router, directly between processes, or all in this process.")
    ] = "routed",
    mode: options.ModeOption = "lockstep",
    realtime_priority: options.RealtimePriority = False,
    router: options.RouterThere = None,
    name: options.FreshRun = None,
    hosts: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Which host runs what (TOML); started there by ssh."),
    ] = None,
    secure: options.Secure = None,
    open_to_all: Annotated[
        bool, typer.Option("--open", help="Hosts that others can reach may do without --secure.")
    ] = False,
    record: options.Record = None,
    rotate: options.Rotate = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the run: .png, .svg, .pdf, .gif or .mp4.")] = None,
    json_file: options.Json = None,
    web: options.Web = False,
    speed: Annotated[
        float | None,
        typer.Option(
            min=0.0, help="Simulated seconds per second in lock-step, 0 for no limit; 1 with --web."
        ),
    ] = None,
    restart: Annotated[
        str,
        typer.Option(
            metavar="POLICY",
            help=f"A process that fails is started again: never, or on-failure[:N] ({RESTARTS} times each).",
        ),
    ] = "never",
    log: options.Log = None,
    quiet: options.Quiet = False,
) -> None:
    """Run a scenario: a router, a world and one process per robot; prints what came of it.

    Example: disknav run figure-1 --record figure-1.mcap --plot figure-1.png

    Exit status: 0 all arrived and nothing touched, 1 ended otherwise, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.library.load import load
    from deploy.processes.hosts.table import read_hosts
    from deploy.run.execute import Extras, execute
    from deploy.telemetry.recording.parts import rotation

    options.refuse_idle(record, rotate, mode, speed)
    if hosts is None:
        options.refuse({"--open": open_to_all}, "it says that --hosts may do without --secure")
    loaded = load(scenario, setting or [], seed)
    if loaded.is_external:
        options.refuse_bases(secure)
    run_name = Membership(secure).run(None if name is None else checked_run(name)) or fresh_run_name()
    pace = speed if speed is not None else 1.0 if web else 0.0
    newcomers = [spec.id for spec in loaded.newcomers]
    hosts_table = None if hosts is None else read_hosts(hosts, loaded.ids, newcomers)
    how = RunOptions(
        transport,
        mode,
        router,
        run_name,
        secure,
        hosts_table,
        open_to_all,
        pace,
        restarts(restart),
        log,
        rotation(rotate or []),
        realtime_priority=realtime_priority,
    )
    begin(LAUNCHER, run_name, log)
    silent = quiet or is_standard_output(json_file)
    tell = (lambda _: None) if silent else show
    result = execute(loaded, how, Extras(record, plot, web, json_file), quiet=silent, tell=tell)
    if not silent:
        from rich.console import Console

        console = Console(soft_wrap=True)
        files = [("recording", each) for each in result["recordings"]]
        files += [(what, target) for what, target in (("picture", plot), ("result", json_file)) if target]
        for what, target in files:
            console.print(f"{what}: {target}", highlight=False)
    raise typer.Exit(exit_status(result))
