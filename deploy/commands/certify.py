"""`disknav certify`: prove by computation from which k on a scenario's goal is the only minimum."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.output.exit_status import EXIT_ARRIVED, EXIT_INTERRUPTED, EXIT_OTHERWISE

if TYPE_CHECKING:
    from deploy.theory.certify.session import Outcome
    from deploy.theory.certify.verifier.replay import Replay


def certify(
    scenario: Annotated[str | None, typer.Argument(help="A scenario file, or a library name.")] = None,
    k: Annotated[
        float | None,
        typer.Option("--k", min=1.0, help="Prove down to this; else as far down as time allows."),
    ] = None,
    minutes: Annotated[float, typer.Option(min=0.0, help="Stop after this long.")] = 10.0,
    verify: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Check a certificate with arithmetic of its own.")
    ] = None,
    file: Annotated[
        Path | None, typer.Option(help="The certificate; SCENARIO.certificate.json unless given.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Spread the search over the Dask cluster there.")
    ] = None,
    setting: Annotated[list[str] | None, typer.Option("--set", help="path.to.key=VALUE.")] = None,
    starts: Annotated[
        int | None,
        typer.Option(min=1, help="No proof: how many of so many random starts fail at the scenario's k."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the random starts.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON instead.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Prove a K: for every k >= K the goal is the only minimum of phi, all else critical a saddle or maximum.

    Goes from large k downwards and can be stopped at any time; the same command goes on from the file.
    [b]--verify FILE[/b] replays the branching in arbitrary precision, and shares no arithmetic with the
    search; with SCENARIO it also asks whether the certificate is of these goals.

    [b]--starts N[/b] follows the exact flow from random starts instead, and bounds the failing fraction: for
    five robots and more, whose proofs take long.

    Examples: disknav certify figure-2 --k 10; disknav certify --verify figure-2.certificate.json;
    disknav certify figure-3e --starts 300

    Exit status: 0 proven (K, or anything without --k) or every start arrived, 1 not within the time or a
    start failed, 2 invalid, 130 interrupted.
    """
    from deploy.library.load import read
    from protocol.errors import UsageError

    read_scenario = None if scenario is None else read(scenario, setting or [])
    if verify is not None:
        from deploy.theory.certify.certificate import Goals, fetch
        from deploy.theory.certify.verifier.replay import replay

        goals = None if read_scenario is None else Goals.of(read_scenario)
        checked = replay(fetch(verify, goals), minutes, quiet)
        _say(_verified(checked), checked.to_json(), as_json)
        raise typer.Exit(_status(checked.enough(k), checked.interrupted))
    if scenario is None or read_scenario is None:
        raise UsageError("certify needs a SCENARIO, or --verify FILE")
    if starts is not None:
        raise typer.Exit(_statistics(scenario, setting or [], starts, seed, as_json))
    from deploy.theory.certify.session import Request, to_json
    from deploy.theory.certify.session import certify as perform

    outcome = perform(read_scenario, Request(scenario, k, minutes, file, scheduler, quiet))
    _say(_found(outcome), to_json(outcome), as_json)
    raise typer.Exit(_status(outcome.proven, outcome.interrupted))


def _statistics(name: str, settings: list[str], starts: int, seed: int, as_json: bool) -> int:
    from dataclasses import asdict, replace

    from deploy.library.load import load
    from deploy.output.bar import bar
    from deploy.theory.certify.certificate import Goals
    from deploy.theory.certify.statistics import failing_fraction

    valid = load(name, settings)
    with bar("random starts") as tell:
        problem = replace(Goals.of(valid).problem, k=valid.k)
        found = failing_fraction(problem, starts, seed, tell)
    _say(str(found), asdict(found), as_json)
    return EXIT_OTHERWISE if found.failed else EXIT_ARRIVED


def _status(proven: bool, interrupted: bool) -> int:
    if proven:
        return EXIT_ARRIVED
    return EXIT_INTERRUPTED if interrupted else EXIT_OTHERWISE


def _say(text: str, data: dict[str, object], as_json: bool) -> None:
    sys.stdout.write((json.dumps(data, indent=2) if as_json else text) + "\n")


def _found(outcome: Outcome) -> str:
    found = outcome.certificate
    if found.proven is None:
        text = f"{found.scenario}: nothing proven yet"
    else:
        text = (
            f"{found.scenario}: proven for every k >= {found.proven:g}: the goal is the only minimum, every "
            f"other critical point has a direction of descent ({found.boxes:,} boxes, {found.time:.1f} s)"
        )
    if found.frontier is not None:
        text += f"\n{found.k:g} is {found.frontier.done:.1%} done; the same command goes on from there"
    return f"{text}\n{outcome.path}"


def _verified(checked: Replay) -> str:
    if checked.proven is None:
        return f"{checked.scenario}: nothing verified"
    return f"{checked.scenario}: verified for every k >= {checked.proven:g} ({checked.boxes:,} boxes)"
