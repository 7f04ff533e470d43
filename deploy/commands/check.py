"""`disknav check`: what the theory says of a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

from deploy.commands import options
from deploy.output import json_output

if TYPE_CHECKING:
    from rich.console import RenderableType

    from deploy.theory.check.check import Certified
    from protocol.scenario.model import Scenario


def check(
    scenario: options.Scenario,
    seed: options.Seed = None,
    setting: options.Settings = None,
    json_file: options.Json = None,
) -> None:
    """Say whether a scenario is valid, whether its goals are admissible, and which k the theory asks for.

    Example: disknav check figure-2

    Exit status: 0 valid (whatever the theory says), 2 invalid.
    """
    from deploy.library.load import load
    from deploy.theory.check.check import report, to_json
    from deploy.theory.check.render import render
    from deploy.theory.check.surrounded import surrounded, theorem_for

    json_output.check(json_file)
    valid = load(scenario, setting or [], seed)
    shown: RenderableType
    if theorem_for(valid)[0] == "Karagoz-Bozma-Koditschek":
        found = report(valid, _certificate(scenario, valid))
        plain, shown = to_json(found), render(found)
    else:
        among = surrounded(valid)
        plain, shown = among.to_json(), among.render()
    json_output.write_json(plain, json_file)
    if not json_output.is_standard_output(json_file):
        from rich.console import Console

        Console().print(shown)


def _certificate(name: str, scenario: Scenario) -> Certified | None:
    """What lies beside the scenario."""
    from deploy.theory.certify.certificate import ProofError, path_for, stored
    from deploy.theory.check.check import Certified

    path = str(path_for(name))
    try:
        found = stored(name, scenario)
    except ProofError as error:
        return Certified(path, None, str(error))
    return None if found is None else Certified(path, found.proven)
