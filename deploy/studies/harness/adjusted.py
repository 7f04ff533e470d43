"""Scenarios of a study with settings laid over them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from deploy.library.load import resolved
from deploy.studies.harness.study import Build, Study
from protocol.scenario.file import apply_settings, document_of, parse_document
from protocol.scenario.model import Scenario


def adjusted(study: Study, settings: Sequence[str]) -> Study:
    """The same study, every scenario with `path.to.key=VALUE` settings over it."""
    if not settings:
        return study
    cells = [
        replace(cell, build=partial(adjusted_scenario, cell.build, tuple(settings))) for cell in study.cells
    ]
    return replace(study, cells=cells)


def adjusted_scenario(build: Build, settings: Sequence[str], seed: int) -> Scenario:
    """One scenario, read again with the settings over it.

    Raises:
        ScenarioError: a setting names no key, or gives no valid scenario.
    """
    scenario = build(seed)
    return resolved(parse_document(apply_settings(document_of(scenario), settings), scenario.name))
