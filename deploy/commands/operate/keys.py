"""`disknav keys`: certificates that say who is who in a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deploy.commands import options
from deploy.run.options import fresh_run_name
from protocol.errors import UsageError
from protocol.keys import checked_run

app = typer.Typer(name="keys", help="Make the certificates of a run.", no_args_is_help=True)


@app.callback()
def keys() -> None:
    """Make the certificates of a run."""


@app.command()
def new(
    directory: Annotated[Path, typer.Argument(help="Directory to make.")],
    scenario: Annotated[
        str,
        typer.Option(
            "--scenario",
            "-s",
            help="A scenario file or library name: its robots take part, also those that orders add.",
        ),
    ],
    run: options.FreshRun = None,
    host: Annotated[
        list[str] | None,
        typer.Option(help="Name or address, besides those of this host, of the one router; repeatable."),
    ] = None,
    hosts: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Table of hosts: each gets a router's key for its robots only."),
    ] = None,
    days: Annotated[float, typer.Option(min=0.0, help="For how long they are valid.")] = 30.0,
    force: Annotated[bool, typer.Option("--force", help="Replace keys that are there already.")] = False,
) -> None:
    """Make an authority and one certificate each for router, world, monitor, operator and every robot.

    With [b]--hosts[/b], one for the router of each host, which speaks for the robots there and no others.

    With [b]--secure DIR[/b] other commands use them: every link is TLS, both ends prove who they are, and
    the router lets each robot write under its own id only. A host needs ca.pem, roster.json and
    the two files of each role that runs there.

    Example: disknav keys new keys --scenario figure-1 --host 10.0.0.1 && disknav run figure-1 --secure keys
    """
    from deploy.library.load import read
    from deploy.processes.hosts.protection import roster_of
    from deploy.processes.hosts.table import read_hosts
    from deploy.security.keystore import create
    from deploy.security.roster import Roster

    name = fresh_run_name() if run is None else checked_run(run)
    found = read(scenario)
    ids, newcomers = found.ids, [spec.id for spec in found.newcomers]
    if hosts is not None and host:
        raise UsageError("the table says where each router is: leave out --host, or --hosts")
    if hosts is None:
        roster = Roster(name, tuple(sorted({*ids, *newcomers})))
    else:
        roster = roster_of(name, read_hosts(hosts, ids, newcomers))
    end = create(directory, roster, hosts=host or (), days=days, force=force)
    print(
        f"{directory}: {len(roster.roles)} certificates for the run {name}, "
        f"valid until {end:%Y-%m-%d %H:%M} UTC"
    )
