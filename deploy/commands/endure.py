"""`disknav endure` and `disknav flood`: how a fleet endures hours, and floods."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from deploy.commands import options
from deploy.output import json_output
from deploy.output.bar import bar
from deploy.output.exit_status import EXIT_ARRIVED, EXIT_INTERRUPTED, EXIT_OTHERWISE
from deploy.run.options import RunOptions, fresh_run_name
from deploy.security.membership import Membership

_Real = Annotated[
    Literal["routed", "mesh"], typer.Option("--transport", help="Through a router, or directly.")
]
_MANY = 9999  # restarts of a process, more than a trial has


def endure(
    minutes: Annotated[
        float | None, typer.Option("--minutes", "-m", min=0.02, help="For how long; 1 unless given.")
    ] = None,
    hours: Annotated[float | None, typer.Option("--hours", min=0.001, help="The same, in hours.")] = None,
    kill_every: Annotated[
        float, typer.Option("--kill-every", metavar="SECONDS", min=0.0, help="Kill a process; 0 for never.")
    ] = 0.0,
    cut_every: Annotated[
        float, typer.Option("--cut-every", metavar="SECONDS", min=0.0, help="Cut a link; 0 for never.")
    ] = 0.0,
    robots: Annotated[int, options.robots(2)] = 16,
    mode: options.ModeOption = "realtime",
    realtime_priority: options.RealtimePriority = False,
    transport: _Real = "routed",
    secure: options.Secure = None,
    json_file: options.Json = None,
    quiet: options.Quiet = False,
) -> None:
    """Keep a fleet moving at 20 Hz, and watch memory, file handles and threads of every process.

    Robots on a circle change places, and back, over and over. Judged: no command missed, real time kept,
    nothing touched, all arrived, handles and threads no more in the last quarter than in the second, and
    memory flat: a line fitted to a process's memory that no file backs, over the second half of its life,
    rises by no more than 0.5 MB or 2 % of it, whichever is more.

    With --kill-every robots are killed by lot, and with every tenth kill the router, with every tenth the
    world, and all are started again; with --cut-every nothing passes a robot's link for 8 s. A robot that
    was under way has to move again within 5 s; commands that are missed and time that is lost meanwhile are
    not judged.

    Example: disknav endure --hours 8 --kill-every 60 --cut-every 300 --json endurance.json

    Exit status: 0 all of it holds, 1 not, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.studies.endurance.endure import endure as perform
    from deploy.studies.endurance.outcome import table
    from deploy.studies.endurance.trial import Trial

    if hours is not None:
        options.refuse({"--minutes": minutes}, "--hours says how long already")
        minutes = 60.0 * hours
    if transport == "mesh":
        options.refuse({"--cut-every": cut_every or None}, "links are cut on their way to a router")
    run = Membership(secure).run(None) or fresh_run_name()
    how = RunOptions(
        transport,
        mode,
        run=run,
        secure=secure,
        restarts=_MANY if kill_every else 0,
        realtime_priority=realtime_priority,
    )
    trial = Trial(robots, 1.0 if minutes is None else minutes, how, kill_every, cut_every)
    json_output.check(json_file)
    silent = quiet or json_output.is_standard_output(json_file)
    with bar("endure", silent=silent) as tell:
        outcome = perform(trial, tell)
    _finish(outcome, table, json_file, silent)


def flood(
    rate: Annotated[float, typer.Option(min=1.0, help="Messages per second.")] = 10_000.0,
    robots: Annotated[int, options.robots(2)] = 6,
    rounds: Annotated[int, typer.Option(min=1, help="Stretches without, and with the flood.")] = 5,
    seconds: Annotated[float, typer.Option(min=0.1, help="How long each is.")] = 2.0,
    unprotected: Annotated[
        bool, typer.Option("--open", help="Without certificates and access rules; its rate is not judged.")
    ] = False,
    role: Annotated[
        Literal["monitor", "operator", "robot"] | None,
        typer.Option(
            "--as",
            help="Whose certificate the flooder has; monitor unless given. A robot's rate is not judged.",
        ),
    ] = None,
    json_file: options.Json = None,
    quiet: options.Quiet = False,
) -> None:
    """Flood a lock-step fleet with garbage, in turns with letting it alone, and see what that does to it.

    The flooder is a client of the fleet's router, with a certificate. It sends random and
    damaged payloads under the fleet's keys, foreign keys, and payloads that are too large. Judged: the rate
    of the flood, ticks at most 20 % slower, nothing touched, trajectories the same, and that nothing gets
    past the router, or (--open, or what a robot's rules allow it) that receivers count what they reject.

    Example: disknav flood --json flood.json && disknav flood --open

    Exit status: 0 all of it holds, 1 not, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.studies.flooding.flood import Plan, table
    from deploy.studies.flooding.flood import flood as perform

    if unprotected:
        options.refuse({"--as": role}, "nobody has a certificate; leave out --open")
    json_output.check(json_file)
    silent = quiet or json_output.is_standard_output(json_file)
    with bar("flood", silent=silent) as tell:
        outcome = perform(Plan(rate, robots, rounds, seconds, not unprotected, role or "monitor"), tell)
    _finish(outcome, table, json_file, silent)


def _finish(
    outcome: dict[str, Any], table: Callable[[dict[str, Any]], Any], target: Path | None, silent: bool
) -> None:
    """Write, print and exit."""
    from deploy.run.outcome.unjudged import INTERRUPTED

    json_output.write_json(outcome, target)
    if not silent:
        from rich.console import Console

        Console(soft_wrap=True).print(table(outcome))
    if outcome["ended"] == INTERRUPTED:
        raise typer.Exit(EXIT_INTERRUPTED)
    raise typer.Exit(EXIT_ARRIVED if outcome["passed"] else EXIT_OTHERWISE)
