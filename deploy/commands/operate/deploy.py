"""`disknav deploy`: files by which an existing orchestrator runs a fleet."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from deploy.commands import options
from deploy.run.options import fresh_run_name
from deploy.security.membership import Membership
from protocol.errors import UsageError
from protocol.keys import checked_run

Orchestrator = Literal["compose", "kubernetes", "systemd"]


def deploy(
    orchestrator: Annotated[Orchestrator, typer.Argument(help="What is to run the fleet.")],
    scenario: options.Scenario,
    out: Annotated[Path, options.out("Folder to make.", "--output", metavar="FOLDER")],
    run: options.FreshRun = None,
    mode: options.ModeOption = "realtime",
    seed: options.Seed = None,
    setting: options.Settings = None,
    image: Annotated[
        str | None,
        typer.Option(help="compose, kubernetes: image with this software; localhost/disknav unless given."),
    ] = None,
    wait: Annotated[
        float, typer.Option(min=1.0, help="How long router, world and robots may take to be there, s.")
    ] = 300.0,
    router: Annotated[
        str | None,
        typer.Option(
            metavar="ENDPOINT",
            help="systemd: where the fleet's router listens; tls/127.0.0.1:7447 unless given.",
        ),
    ] = None,
    days: Annotated[float, typer.Option(min=0.0, help="For how long the certificates are valid.")] = 30.0,
) -> None:
    """Write what Docker Compose, Kubernetes or systemd needs to run a scenario, keys included.

    The first lines of the main file say how to start it. Every process gets its own key and no other;
    who has the folder has them all.

    Example: disknav deploy compose figure-1 -o fleet && cd fleet && docker compose up
    """
    from deploy.library.load import load
    from deploy.manifests.folder import write
    from deploy.manifests.plan import Plan, installation
    from deploy.security.roster import Roster
    from protocol.scenario.file import write_toml

    if orchestrator == "systemd":
        options.refuse({"--image": image}, "systemd runs no containers")
    else:
        options.refuse({"--router": router}, f"{orchestrator} gives the router a name of its own")
    loaded = load(scenario, setting or [], seed)
    if loaded.is_external:
        raise UsageError("bases outside and keys cannot go together: start the fleet by hand, without")
    added = {spec.id for spec in loaded.newcomers}
    if again := sorted(added & {*loaded.ids}):
        raise UsageError(
            f"orders of the scenario add robot {again[0]} again, and nobody would start its process a second "
            "time; give who comes an id of its own"
        )
    run_name = fresh_run_name() if run is None else checked_run(run)
    roster = Roster(run_name, tuple(sorted({*loaded.ids, *added})))
    command = str(Path(sys.executable).parent / "disknav")
    endpoint = None if router is None else str(Membership(out).endpoint(router))
    chosen = {"image": image, "router": endpoint}
    named = {name: value for name, value in chosen.items() if value is not None}
    plan = Plan(
        roster,
        write_toml(loaded),
        mode,
        command=command,
        software=installation(),
        wait=wait,
        **named,
    )
    write(out, orchestrator, plan, days)
    print(f"{out}: the run {roster.run} for {orchestrator}")
