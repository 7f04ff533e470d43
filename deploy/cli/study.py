"""`disknav study`: tables measured over many runs; stopped whenever, and gone on with."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from deploy.cli import options
from deploy.output import is_standard_output
from deploy.run.options import Transport
from deploy.studies.study import StudyName


def study(
    name: Annotated[StudyName, typer.Argument(help="Name of the study.")],
    runs: Annotated[
        int | None, typer.Option("--runs", min=1, help="Runs per cell; each study has its own default.")
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", "-j", min=1, help="Parallel runs; by default one per core."),
    ] = None,
    shard: Annotated[
        str | None,
        typer.Option(
            metavar="I/N", help="Only every N-th run from the I-th on, to share a study between machines."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first run; the others count up.")] = 0,
    setting: options.Settings = None,
    transport: Annotated[
        Transport | None, typer.Option(help="Real processes (routed, mesh) or one process (local).")
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(metavar="MODULE:CLASS", help="peers: another law to compare; repeatable."),
    ] = None,
    only: Annotated[
        list[str] | None,
        typer.Option(metavar="TEXT", help="peers: only scenarios whose names contain this text; repeatable."),
    ] = None,
    json_file: options.Json = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the rows: .png, .svg or .pdf.")] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Discard the results of an earlier call.")] = False,
    quiet: options.Quiet = False,
) -> None:
    """Run a study and print its table: the paper's experiments, faults, late states, peers, fleet sizes.

    Every finished run is kept in FILE.runs.jsonl beside the --json FILE; the same command goes on from
    there after Ctrl-C or a crash, unless the code or the settings have changed.

    Examples: disknav study tightness --json tightness.json --plot tightness.png;
    disknav study tuning --runs 5 --transport local;
    disknav study peers --law courtesy.py:Courtesy --only "swap 1"

    With [b]--shard I/N[/b] N machines share a study. The parts' FILE.runs.jsonl, one after the other in one,
    are that of the whole: the same command without --shard then makes the table of all runs.

    Exit status: 0 done, 1 done but something touched that must not, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.studies.perform import Request, perform
    from deploy.studies.study import Shard

    if name != "peers":
        options.refuse({"--law": law, "--only": only}, f"study {name} has no laws beside each other")
    if name == "scale":
        options.refuse({"--jobs": jobs}, "study scale measures speed: one run at a time")
    if json_file is None or is_standard_output(json_file):
        options.refuse({"--fresh": fresh}, "only --json FILE keeps what was measured")
    request = Request(
        name=name,
        runs=runs,
        jobs=jobs or os.cpu_count() or 1,
        seed=seed,
        settings=tuple(setting or ()),
        transport=transport,
        shard=Shard() if shard is None else Shard.parse(shard),
        target=json_file,
        plot=plot,
        fresh=fresh,
        quiet=quiet,
        laws=tuple(law or ()),
        only=tuple(only or ()),
    )
    raise typer.Exit(perform(request))
