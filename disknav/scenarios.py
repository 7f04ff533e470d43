"""Scenarios: from the library, from files, or put together in Python."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from deploy.library.load import catalogue, prepared
from deploy.library.load import load as load_named
from protocol.errors import UsageError
from protocol.scenario.file import apply_settings, parse_document, toml_value
from protocol.scenario.model import Scenario

Settings = Mapping[str, Any]
Source = Scenario | str | Path


def library() -> dict[str, str]:
    """Description of each library scenario by name; `N` in a name is a number of robots."""
    return {entry.name: entry.text for entry in catalogue()}


def load(source: str | Path, settings: Settings | None = None, *, seed: int | None = None) -> Scenario:
    """Load a library scenario (`"figure-1"`) or a TOML file, validated and ready to run.

    Args:
        settings: values that override the scenario's, by path:
            `{"control.k": 80, "robots[0].goal": (0.1, 0.0)}`.
        seed: overrides the scenario's; a library scenario draws its random starts from it.

    Raises:
        ScenarioError: the scenario or a setting is invalid; `problems` lists all problems.
        UsageError: no such file or name, or a library that the law needs is missing.
    """
    return load_named(str(source), _written(settings or {}), seed)


def ready(source: Source, settings: Settings | None, seed: int | None) -> Scenario:
    """Return a scenario as it is, and load a name or file.

    Raises:
        ScenarioError, UsageError: as `load`; or `settings` or `seed` are given with a finished scenario.
    """
    if not isinstance(source, Scenario):
        return load(source, settings, seed=seed)
    if settings or seed is not None:
        raise UsageError("settings and seed are for a name or file: give them to load or build instead")
    return source


def build(document: Mapping[str, Any], settings: Settings | None = None) -> Scenario:
    """Build a scenario from the tables of a scenario file; missing keys have their defaults.

    Args:
        document: such as `{"robots": [{"id": 1, "radius": 0.04, "start": [-0.2, 0], "goal": [0.2, 0]}]}`;
            docs/reference/scenario.md lists the keys. numpy arrays are accepted.
        settings: as in `load`.

    Raises:
        ScenarioError: as in `load`.
        UsageError: a law from outside is missing, too slow or without its library, or `control.k` is
            "certified".
    """
    return prepared(parse_document(apply_settings(_table(document), _written(settings or {}))))


def _written(settings: Settings) -> list[str]:
    """As `--set` takes them."""
    return [f"{path}={toml_value(value)}" for path, value in _table(settings).items()]


def _table(given: Mapping[str, Any]) -> dict[str, Any]:
    plain = json.loads(written(given))
    if not isinstance(plain, dict):
        raise UsageError(f"{plain!r:.60}: give a dictionary, such as {{'control.k': 80}} for settings")
    return plain


def written(value: Any) -> str:
    """A value as JSON: arrays and numbers of numpy as lists and numbers, a class as `module:Class`; raises
    UsageError if JSON cannot say it."""
    try:
        return json.dumps(value, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:  # of a key, of a list that contains itself
        raise UsageError(f"{error}: give numbers, strings, arrays and tables") from None


def _plain(value: Any) -> Any:
    if isinstance(value, type):
        return f"{value.__module__}:{value.__qualname__}"
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a value of type {type(value).__name__} is none of a scenario")
