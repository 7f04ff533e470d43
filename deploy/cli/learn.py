"""The commands check, certify and study: theory of a scenario, proof of a K, and measurements."""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.cli import options
from deploy.output import (
    EXIT_ARRIVED,
    EXIT_OTHERWISE,
    check_target,
    check_text,
    is_standard_output,
    print_whole,
    write_json,
)
from deploy.run.options import Transport
from deploy.studies import StudyName

if TYPE_CHECKING:
    from deploy.theory.certify.certificate import Certificate
    from deploy.theory.certify.replay import Replay
    from deploy.theory.check import Certified
    from protocol.scenario.model import Scenario


def check(
    scenario: options.Scenario,
    seed: options.Seed = None,
    setting: options.SettingOptions = None,
    json_file: options.JsonFile = None,
) -> None:
    """Validate a scenario and evaluate the theory: whether its goals are admissible, and the required k.

    Example: disknav check figure-2

    Exit status: 0 valid (whatever the theory states), 2 invalid.
    """
    from deploy.library.load import load
    from deploy.theory.check import CheckReport, report, scope
    from deploy.theory.facts import plain
    from deploy.theory.surrounded import Surrounded, surrounded, theorem_for

    check_text(json_file, scenario)
    valid = load(scenario, setting or [], seed)
    alone = theorem_for(valid)[0] == "Karagoz-Bozma-Koditschek"
    found: CheckReport | Surrounded
    found = report(valid, _certificate(scenario, valid)) if alone else surrounded(valid)
    write_json(plain(found), json_file)
    if not is_standard_output(json_file):
        from rich.console import Console

        Console().print(found.render(), *scope(valid), sep="\n", highlight=False)


def _certificate(name: str, scenario: Scenario) -> Certified | None:
    from deploy.theory.certify.certificate import ProofError, path_for, stored
    from deploy.theory.check import Certified

    path = str(path_for(name))
    try:
        found = stored(name, scenario)
    except ProofError as error:
        return Certified(path, None, str(error))
    return None if found is None else Certified(path, found.proven)


def certify(
    scenario: Annotated[
        str | None,
        typer.Argument(metavar="SCENARIO", help="A scenario file or library name; optional with --verify."),
    ] = None,
    k: Annotated[
        float | None,
        typer.Option(
            "--k", metavar="K", min=1.0, help="Prove down to this k; default: as far as time allows."
        ),
    ] = None,
    minutes: Annotated[
        float, typer.Option(metavar="M", min=0.0, help="Stop after this many minutes.")
    ] = 10.0,
    verify: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Check a certificate with independent arithmetic.")
    ] = None,
    out: Annotated[
        Path | None, options.out("Certificate to write or continue; default SCENARIO.certificate.json.")
    ] = None,
    setting: options.SettingOptions = None,
    json_file: options.JsonFile = None,
    quiet: options.Quiet = False,
) -> None:
    """Find and prove a K: for every k >= K the goal is the only minimum of phi, all other critical points
    saddles or maxima.

    The search goes from large k downwards and can be stopped at any time; the same command continues it.
    [b]--verify FILE[/b] replays the branching in arbitrary precision, and shares no arithmetic with the
    search; with SCENARIO it also checks that the certificate belongs to these goals.

    Examples: disknav certify figure-2 --k 10; disknav certify --verify figure-2.certificate.json

    Exit status: 0 proven (K, or any k without --k), 1 not within the time, 2 invalid, 130 interrupted.
    """
    from deploy.library.load import read
    from protocol.errors import UsageError

    if verify is not None:
        options.refuse({"--out": out}, "--verify writes no certificate")
        if scenario is None:
            options.refuse({"--set": setting}, "it needs a SCENARIO")
    check_text(json_file, scenario, verify)
    silent = quiet or is_standard_output(json_file)
    read_scenario = None if scenario is None else read(scenario, setting or [])
    if verify is not None:
        from deploy.theory.certify.certificate import GoalSet, fetch
        from deploy.theory.certify.replay import replay

        goals = None if read_scenario is None else GoalSet.of(read_scenario)
        checked = replay(fetch(verify, goals), minutes, silent)
        _print(_verified(checked), asdict(checked), json_file, silent)
        raise typer.Exit(EXIT_ARRIVED if checked.enough(k) else EXIT_OTHERWISE)
    if scenario is None or read_scenario is None:
        raise UsageError("certify needs a SCENARIO, or --verify FILE")
    from deploy.theory.certify.certificate import path_for
    from deploy.theory.certify.prove import certify as perform
    from deploy.theory.certify.prove import to_json

    path = out or path_for(scenario)
    check_text(json_file, path)
    check_target(path, "write the certificate", scenario)
    found = perform(read_scenario, path, k, minutes, quiet=silent)
    _print(f"{_found(found)}\n{path}", to_json(found, path, k), json_file, silent)
    raise typer.Exit(EXIT_ARRIVED if found.proves(k) else EXIT_OTHERWISE)


def _print(text: str, data: dict[str, object], json_file: Path | None, silent: bool) -> None:
    write_json(data, json_file)
    if not silent:
        print(text)


def _found(found: Certificate) -> str:
    if found.proven is None:
        text = f"{found.scenario}: nothing proven yet"
    else:
        text = (
            f"{found.scenario}: proven for every k >= {found.proven:g}: the goal is the only minimum, every "
            f"other critical point has a direction of descent ({found.boxes:,} boxes, {found.time:.1f} s)"
        )
    if found.trial:
        text += f"\n{found.trial.k:g} was {found.trial.done:.1%} done; more --minutes may prove it"
    return text


def _verified(checked: Replay) -> str:
    if checked.verified is None:
        return f"{checked.scenario}: nothing verified"
    return f"{checked.scenario}: verified for every k >= {checked.verified:g} ({checked.boxes:,} boxes)"


def study(
    name: Annotated[StudyName, typer.Argument(metavar="STUDY", help="Name of the study.")],
    runs: Annotated[
        int | None, typer.Option("--runs", min=1, help="Runs per cell; each study has its own default.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, help="Parallel runs; by default one per core.")
    ] = None,
    shard: Annotated[
        str | None,
        typer.Option(
            metavar="I/N", help="Only every N-th run from the I-th on, to share a study between machines."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**62, help="Seed of the first run; others count up.")] = 0,
    setting: options.SettingOptions = None,
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
    json_file: options.JsonFile = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Discard the results of an earlier call.")] = False,
    quiet: options.Quiet = False,
) -> None:
    """Run a study and print its table: the paper's experiments, faults, late states, peers, fleet sizes.
    Most take minutes, peers takes hours unless [b]--only[/b] and [b]--runs[/b] limit it.

    Every finished run is kept in FILE.runs.jsonl beside the --json FILE; the same command goes on from
    there after Ctrl-C or a crash, unless the code or the settings have changed.

    Examples: disknav study tightness --json tightness.json; disknav study tuning --runs 5 --transport local;
    disknav study peers --law courtesy.py:Courtesy --only "swap 10"

    With [b]--shard I/N[/b] N machines share a study. Concatenate the FILE.runs.jsonl of all shards into one:
    the same command without --shard then makes the table of all runs.

    Exit status: 0 done, 1 done, but with contacts that must not happen, 2 invalid, 3 fault, 130 interrupted.
    """
    from deploy.software import provenance
    from deploy.studies.execution import RunLog, execute
    from deploy.studies.perform import built, status, table, usual_transport
    from deploy.studies.study import Shard

    if name != "peers":
        options.refuse({"--law": law, "--only": only}, f"study {name} compares no laws")
    if name == "scale":
        options.refuse({"--jobs": jobs}, "study scale measures speed: one run at a time")
    file = None if is_standard_output(json_file) else json_file
    if file is None:
        options.refuse({"--fresh": fresh}, "no results are kept: add --json FILE")
    check_text(json_file, *(each.rpartition(":")[0] for each in law or ()))
    bus, part = transport or usual_transport(name), Shard() if shard is None else Shard.parse(shard)
    jobs = 1 if name == "scale" else jobs or os.cpu_count() or 1
    silent = quiet or is_standard_output(json_file)
    found = built(name, seed, runs, transport, law or (), only or ()).adjusted(setting or ())
    found.cells[0].build(found.cells[0].seeds[0])  # an invalid setting is found before any run
    log = RunLog(None if file is None else file.with_name(f"{file.name}.runs.jsonl"), fresh=fresh)
    outcome = execute(found, bus, log, jobs=jobs, quiet=silent, shard=part)
    about = {"shard": str(part), "settings": setting or [], "complete": outcome.complete}
    document = {"study": name, "rows": outcome.rows, "provenance": provenance(seed, bus, jobs) | about}
    write_json(document, json_file)
    if not silent:
        print_whole(table(found, outcome.rows))
    raise typer.Exit(status(found, outcome, file))
