"""`disknav hosts`: whether the hosts of a table are fit for a run, and this software put on them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated

import typer

from deploy.output.exit_status import EXIT_ARRIVED, EXIT_OTHERWISE

MARKS = {"good": "ok", "note": "--", "bad": "!!"}
app = typer.Typer(name="hosts", help="Look after the hosts of a fleet.", no_args_is_help=True)

Table = Annotated[
    Path, typer.Argument(metavar="TABLE", help="Which host runs what (TOML), as for run --hosts.")
]


@app.callback()
def hosts() -> None:
    """Look after the hosts of a fleet."""


@app.command()
def check(table: Table) -> None:
    """Find out whether every host can be reached, has this version, a sound clock, its port and space.

    Example: disknav hosts check hosts.toml

    Exit status: 0 all are fit for a run, 1 one is not, 2 the table is invalid.
    """
    from rich.console import Console
    from rich.table import Table as Rows
    from rich.text import Text

    from deploy.processes.hosts.check import check as look
    from deploy.processes.hosts.relay import printable
    from deploy.processes.hosts.table import read_any_hosts

    found = read_any_hosts(table).hosts
    with ThreadPoolExecutor(len(found)) as pool:
        findings = list(pool.map(look, found))
    rows = Rows(box=None, pad_edge=False)
    for title in ("host", "", "what", "how it is"):
        rows.add_column(title)
    for host, about in zip(found, findings, strict=True):
        for each in about:
            rows.add_row(host.name, MARKS[each.level], each.what, Text(printable(each.text)))
    Console(soft_wrap=True, highlight=False).print(rows)
    fine = all(each.level != "bad" for about in findings for each in about)
    raise typer.Exit(EXIT_ARRIVED if fine else EXIT_OTHERWISE)


@app.command()
def install(table: Table) -> None:
    """Put this checkout on every host reached by ssh, where the table's `command` says: FOLDER/bin/disknav.

    Needed there: Python with venv, and a package index that pip reaches; a C compiler and make to compile.

    Example: disknav hosts install hosts.toml && disknav hosts check hosts.toml
    """
    from deploy.processes.hosts.install import install as put
    from deploy.processes.hosts.table import read_any_hosts

    for host in read_any_hosts(table).hosts:
        if host.ssh:
            print(f"{host.name}: {put(host)}", flush=True)
