"""`disknav run`: a scenario from start to verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deploy.output.json_output import is_standard_output
from deploy.run.options import RESTARTS, Mode, RunOptions, Transport, fresh_run_name, restarts
from deploy.run.result import exit_status, table
from deploy.security.membership import Membership
from protocol.keys import checked_run


def run(
    scenario: Annotated[
        str, typer.Argument(help="A scenario file (TOML), or a library name such as figure-1.")
    ],
    seed: Annotated[int | None, typer.Option(help="Seed, over the scenario's.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="path.to.key=VALUE, over the file.")
    ] = None,
    transport: Annotated[
        Transport, typer.Option(help="Through a router, directly between processes, or all in this process.")
    ] = "routed",
    mode: Annotated[Mode, typer.Option(help="Who sets the pace: the robots or the wall clock.")] = "lockstep",
    router: Annotated[str | None, typer.Option(help="Use the router at this endpoint; start none.")] = None,
    name: Annotated[
        str | None, typer.Option("--run", help="Name of the run; a fresh one unless given.")
    ] = None,
    hosts: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Which host runs what (TOML); started there by ssh."),
    ] = None,
    secure: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Certificates and access rules from `disknav keys new DIR`."),
    ] = None,
    open_to_all: Annotated[
        bool, typer.Option("--open", help="Hosts that others can reach may do without --secure.")
    ] = False,
    record: Annotated[
        Path | None, typer.Option(help="Record everything that crosses the network (MCAP).")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the run: .png, .svg, .pdf, .gif or .mp4.")] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the result; '-' for standard output.")
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve a live page; its address is printed.")] = False,
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
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress and no table.")] = False,
) -> None:
    """Run a scenario: a router, a world and one process per robot; prints what came of it.

    Example: disknav run figure-1 --record figure-1.mcap --plot figure-1.png

    Exit status: 0 all arrived and nothing touched, 1 ended otherwise, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.library.load import load
    from deploy.processes.hosts.table import read_hosts
    from deploy.run.execute import Extras, execute

    loaded = load(scenario, setting or [], seed)
    run_name = Membership(secure).run(None if name is None else checked_run(name)) or fresh_run_name()
    pace = speed if speed is not None else 1.0 if web else 0.0
    hosts_table = None if hosts is None else read_hosts(hosts, loaded.ids)
    options = RunOptions(
        transport, mode, router, run_name, secure, hosts_table, open_to_all, pace, restarts(restart)
    )
    silent = quiet or is_standard_output(json_file)
    result = execute(loaded, options, Extras(record, plot, web, json_file), quiet=silent)
    if not silent:
        from rich.console import Console

        console = Console(soft_wrap=True)
        console.print(table(result))
        files = [("recording", each) for each in result["recordings"]]
        files += [(what, target) for what, target in (("picture", plot), ("result", json_file)) if target]
        for what, target in files:
            console.print(f"{what}: {target}", highlight=False)
    raise typer.Exit(exit_status(result))
