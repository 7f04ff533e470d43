"""`disknav certify`: prove by computation from which k on a scenario's goal is the only minimum."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.cli import options
from deploy.output import EXIT_ARRIVED, EXIT_OTHERWISE, check_json, is_standard_output, write_json

if TYPE_CHECKING:
    from deploy.theory.certify.prove import Outcome
    from deploy.theory.certify.replay import Replay

_MINUTES = 10.0


def certify(
    scenario: Annotated[
        str | None,
        typer.Argument(
            metavar="SCENARIO",
            help="A scenario file or library name; optional with --verify.",
        ),
    ] = None,
    k: Annotated[
        float | None,
        typer.Option("--k", min=1.0, help="Prove down to this k; by default as far down as time allows."),
    ] = None,
    minutes: Annotated[
        float | None, typer.Option(min=0.0, help="Stop after this many minutes; default 10.")
    ] = None,
    verify: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Check a certificate with independent arithmetic.")
    ] = None,
    out: Annotated[
        Path | None,
        options.out("The certificate, or where to go on; SCENARIO.certificate.json unless given.", "--file"),
    ] = None,
    setting: options.Settings = None,
    starts: Annotated[
        int | None,
        typer.Option(
            min=1, help="No proof: run this many random starts at the scenario's k and count failures."
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the random starts; default 0.")] = None,
    json_file: options.Json = None,
    quiet: options.Quiet = False,
) -> None:
    """Prove a K: for every k >= K the goal is the only minimum of phi, all other critical points saddles or
    maxima.

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

    _check_options(verify is not None, starts is not None, locals())
    check_json(json_file)
    silent = quiet or is_standard_output(json_file)
    read_scenario = None if scenario is None else read(scenario, setting or [])
    if verify is not None:
        from deploy.theory.certify.certificate import Goals, fetch
        from deploy.theory.certify.replay import replay

        goals = None if read_scenario is None else Goals.of(read_scenario)
        checked = replay(fetch(verify, goals), _MINUTES if minutes is None else minutes, silent)
        _say(_verified(checked), checked.to_json(), json_file, silent)
        raise typer.Exit(_status(checked.enough(k)))
    if scenario is None or read_scenario is None:
        raise UsageError("certify needs a SCENARIO, or --verify FILE")
    if starts is not None:
        raise typer.Exit(_statistics(scenario, setting or [], (starts, seed or 0), json_file, silent))
    from deploy.theory.certify.prove import Request, to_json
    from deploy.theory.certify.prove import certify as perform

    limit = _MINUTES if minutes is None else minutes
    outcome = perform(read_scenario, Request(scenario, k, limit, out, silent))
    _say(_found(outcome), to_json(outcome), json_file, silent)
    raise typer.Exit(_status(outcome.proven))


def _check_options(verifies: bool, samples: bool, given: Mapping[str, object]) -> None:
    """Refuse what only one of the three ways to use this command knows."""
    search = {"--out": given["out"]}
    sample = {"--starts": given["starts"], "--seed": given["seed"]}
    if verifies:
        options.refuse({**search, **sample}, "--verify neither searches nor samples")
        if given["scenario"] is None:
            options.refuse({"--set": given["setting"]}, "there is no SCENARIO to set it in")
    elif samples:
        bounds = {"--k": given["k"], "--minutes": given["minutes"]}
        options.refuse({**search, **bounds}, "--starts samples at the scenario's k: --set control.k=K")
    else:
        options.refuse(sample, "without --starts nothing is random")


def _statistics(
    name: str, settings: list[str], sample: tuple[int, int], json_file: Path | None, silent: bool
) -> int:
    from dataclasses import asdict, replace

    from deploy.library.load import load
    from deploy.output import bar
    from deploy.theory.certify.certificate import Goals
    from deploy.theory.exact_flow import failing_fraction

    valid = load(name, settings)
    with bar("random starts", silent=silent) as tell:
        problem = replace(Goals.of(valid).problem, k=valid.k)
        found = failing_fraction(problem, *sample, tell)
    _say(str(found), asdict(found), json_file, silent)
    return EXIT_OTHERWISE if found.failed else EXIT_ARRIVED


def _status(proven: bool) -> int:
    return EXIT_ARRIVED if proven else EXIT_OTHERWISE


def _say(text: str, data: dict[str, object], json_file: Path | None, silent: bool) -> None:
    write_json(data, json_file)
    if not silent:
        print(text)


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
