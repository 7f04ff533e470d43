"""`disknav deploy`: files by which an existing orchestrator runs a fleet."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from deploy.manifests.plan import IMAGE
from deploy.run.options import Mode, fresh_run_name
from protocol.keys import checked_run

Orchestrator = Literal["compose", "kubernetes", "systemd"]


def deploy(
    orchestrator: Annotated[Orchestrator, typer.Argument(help="What is to run the fleet.")],
    scenario: Annotated[str, typer.Argument(help="A scenario file or a library name.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to make.")],
    run: Annotated[str | None, typer.Option(help="Name of the run; a fresh one unless given.")] = None,
    mode: Annotated[Mode, typer.Option(help="Who sets the pace: the robots or the wall clock.")] = "realtime",
    seed: Annotated[int | None, typer.Option(help="Seed, over the scenario's.")] = None,
    setting: Annotated[
        list[str] | None, typer.Option("--set", help="path.to.key=VALUE, over the file.")
    ] = None,
    image: Annotated[str, typer.Option(help="Container image with this software.")] = IMAGE,
    wait: Annotated[
        float, typer.Option(min=1.0, help="How long router, world and robots may take to be there, s.")
    ] = 300.0,
    router: Annotated[
        str, typer.Option(help="systemd: where the router listens and all find it.")
    ] = "tls/127.0.0.1:7447",
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

    loaded = load(scenario, setting or [], seed)
    roster = Roster(fresh_run_name() if run is None else checked_run(run), loaded.ids)
    command = str(Path(sys.executable).parent / "disknav")
    plan = Plan(roster, write_toml(loaded), mode, image, command, installation(), router, wait)
    write(output, orchestrator, plan, days)
    print(f"{output}: the run {roster.run} for {orchestrator}")
