"""`disknav host`: the far end of `disknav run --hosts`, which ssh starts."""

from __future__ import annotations

import os
import sys
from typing import Annotated

import typer


def host(
    run: Annotated[str, typer.Option(help="Name of the run, for `ps`.")] = "",
    realtime_priority: Annotated[
        bool, typer.Option("--realtime-priority", help="Refuse where processes may have none.")
    ] = False,
    facts: Annotated[
        tuple[str, int] | None,
        typer.Option(help="Only say what this host is like; where its router listens."),
    ] = None,
) -> None:
    """Start processes for a launcher on another host, by way of standard input and output."""
    from deploy.processes.scheduling import require_realtime
    from deploy.processes.spawn import environment

    if realtime_priority:
        require_realtime()
    # A fresh interpreter: processes that are forked carry neither this command line nor its libraries.
    # -P: nor what lies in the working directory.
    module, arguments = ("remote", [run]) if facts is None else ("facts", [str(each) for each in facts])
    call = [sys.executable, "-P", "-m", f"deploy.processes.hosts.{module}", *arguments]
    os.execve(sys.executable, call, environment())
