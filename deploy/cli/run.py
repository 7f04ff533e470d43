"""`disknav run`: a scenario from start to verdict."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from deploy.cli import options
from deploy.output import check_target, check_text, is_standard_output
from deploy.run.options import Mode, RunOptions, Transport, fresh_run_name, restarts
from deploy.security.membership import KeyRing
from protocol.keys import checked_run
from protocol.process.log import LAUNCHER, begin
from protocol.process.signals import STOP

_KEPT = "on-failure:1000"  # restarts of a fleet that stays up


def run(
    scenario: options.Scenario,
    seed: options.Seed = None,
    setting: options.SettingOptions = None,
    keep: Annotated[
        bool, typer.Option("--keep", help="Keep the fleet up until Ctrl-C, for [b]disknav fleet[/b].")
    ] = False,
    name: Annotated[
        str | None,
        typer.Option("--run", metavar="NAME", help="Name of the run; with --keep by default the scenario's."),
    ] = None,
    transport: Annotated[
        Transport, typer.Option(help="Through a router, over direct links, or in one process.")
    ] = "routed",
    mode: Annotated[
        Mode | None, typer.Option(help="Ticks wait for all robots, or follow the wall clock.")
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            min=0.0,
            help="Simulated seconds per second; 0: unlimited. Default 0, with --web or --keep 1.",
        ),
    ] = None,
    record: options.Record = None,
    rotate: options.Rotate = None,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the run; .gif, .webp and .mp4 are animations.")
    ] = None,
    json_file: options.JsonFile = None,
    web: options.Web = False,
    router: options.RouterThere = None,
    listen: Annotated[
        str | None,
        typer.Option(
            metavar="ENDPOINT", help="Endpoint at which the router listens; with --keep by default port 7447."
        ),
    ] = None,
    hosts: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Start the processes on the hosts of this table (TOML), over ssh."),
    ] = None,
    secure: options.Secure = None,
    open_to_all: Annotated[
        bool, typer.Option("--open", help="Allow --hosts without --secure; --listen works without it.")
    ] = False,
    restart: Annotated[
        str | None,
        typer.Option(
            metavar="POLICY",
            help="Restart failed processes: never, on-failure[:N]; with --keep by default 1000 times.",
        ),
    ] = None,
    log: options.LogFile = None,
    quiet: options.Quiet = False,
) -> None:
    """Run a scenario with a router, a world and one process per robot, and print the result. The default mode
    is lock-step, with [b]--keep[/b] real time.

    Examples: disknav run figure-1 --record figure-1.mcap --plot figure-1.png;
    disknav run swap-6 --keep --run yard; in another terminal: disknav fleet goal yard 3 0.1 -0.05

    Exit status: 0 all arrived without contact, 1 another verdict, 2 invalid input, 3 fault, 130 Ctrl-C.
    """
    from deploy.library.load import load
    from deploy.processes.hosts.table import read_hosts
    from deploy.run.execute import execute
    from deploy.run.result import exit_status, kept_status, show
    from deploy.telemetry.plot.draw import check
    from deploy.telemetry.recording.writer import rotation

    clock: Mode = mode or ("realtime" if keep else "lockstep")
    if record is None:
        options.refuse({"--rotate": rotate}, "nothing is recorded: add --record")
    check_text(json_file, scenario, hosts, record, plot)
    check_target(record, "record", scenario, hosts)
    check(plot, scenario, hosts, record)
    if clock == "realtime":
        options.refuse({"--speed": speed}, "real time has one speed: use --mode lockstep")
    if hosts is None:
        options.refuse({"--open": open_to_all}, "it allows --hosts without --secure")
    if transport != "routed":
        options.refuse({"--keep": keep}, "orders need a router: leave out --transport")
    if keep:
        options.refuse({"--plot": plot}, "add --record, then use disknav recording plot")
    loaded = load(scenario, [*(setting or []), *(["time.endless=true"] if keep else [])], seed)
    if loaded.has_topics:
        options.refuse_bases(secure)
    membership = KeyRing(secure)
    asked = membership.run(None if name is None else checked_run(name))
    if keep and router is None and listen is None and hosts is None:
        listen = str(membership.endpoint(None))
    how = RunOptions(
        transport=transport,
        mode=clock,
        router=None if router is None else membership.endpoint(router),
        run=asked or (checked_run(loaded.name) if keep else fresh_run_name()),
        secure=secure,
        hosts=None if hosts is None else read_hosts(hosts, loaded),
        open=open_to_all,
        speed=speed if speed is not None else 1.0 if (web or keep) and clock == "lockstep" else 0.0,
        restarts=restarts(restart or (_KEPT if keep else "never")),
        log=log,
        rotation=rotation(rotate or []),
        listen=None if listen is None else membership.endpoint(listen),
    )
    begin(LAUNCHER, how.run, log)
    silent = quiet or is_standard_output(json_file)
    if keep and not silent:
        typer.echo(
            f"starting run {how.run} at {how.router or how.listen or 'its hosts'}; Ctrl-C stops it", err=True
        )
    on_result = (lambda _: None) if silent else show
    result = execute(
        loaded, how, record=record, plot=plot, web=web, json_file=json_file, quiet=silent, on_result=on_result
    )
    if not silent:
        _print_files(result, plot, json_file)
    raise typer.Exit(kept_status(result) if keep else exit_status(result))


def _print_files(result: Mapping[str, Any], plot: Path | None, json_file: Path | None) -> None:
    files = [("recording", each) for each in result["recordings"]]
    drawn = None if STOP.requested else plot
    files += [(what, str(target)) for what, target in (("picture", drawn), ("result", json_file)) if target]
    for what, target in files:
        print(f"{what}: {target}")
