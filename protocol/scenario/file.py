"""Scenario files: TOML in, `Scenario` out, or every problem at once, each with its path.

Positions in paths count from 0, as they stand in the file: `robots[2].start` is the start of the third
`[[robots]]`. Robots are named by their ids: "overlaps robot 1".
"""

from __future__ import annotations

import tomllib
from pathlib import Path

from protocol.errors import DocumentError, Problem, ScenarioError
from protocol.scenario.checks.bodies import with_radii
from protocol.scenario.checks.fields import checked
from protocol.scenario.model import Scenario
from protocol.scenario.schema import json_schema, typed
from protocol.scenario.settings import apply_settings
from protocol.scenario.shape import Document, Steps, file_order, written
from protocol.scenario.toml import document_of, write_toml

__all__ = [
    "apply_settings",
    "document_of",
    "json_schema",
    "parse_document",
    "parse_toml",
    "read_document",
    "read_scenario",
    "read_toml",
    "validated",
    "write_toml",
]


def read_scenario(path: Path | str) -> Scenario:
    """Read and check a scenario file; raises ScenarioError."""
    return parse_document(read_document(path), str(path))


def read_document(path: Path | str) -> Document:
    """Read a TOML file without checking what it says.

    Raises:
        ScenarioError: the file cannot be read, or is not TOML.
    """
    return read_toml(path, ScenarioError)


def read_toml(path: Path | str, failure: type[DocumentError]) -> Document:
    """Read a TOML file without checking what it says; raises `failure` where it cannot be read as one."""
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise failure(str(path), [Problem("", f"cannot be read: {error.strerror or error}")]) from None
    except UnicodeDecodeError as error:
        raise failure(str(path), [Problem("", f"is not UTF-8 text (byte {error.start})")]) from None
    return _loads(text, str(path), failure)


def parse_toml(text: str, source: str = "scenario") -> Scenario:
    """A scenario from TOML text; `source` names it in errors. Raises ScenarioError."""
    return parse_document(_loads(text, source), source)


def parse_document(document: Document, source: str = "scenario") -> Scenario:
    """A scenario from plain tables, arrays and values, as tomllib makes them.

    Raises:
        ScenarioError: with every problem, in the order of the file.
    """
    single = isinstance(document.get("sensing"), dict)
    arrays = with_radii(document | {"sensing": [document["sensing"]]} if single else document)
    scenario, findings = typed(arrays, Scenario)
    findings += checked(arrays, [steps for steps, _ in findings])
    if scenario is not None and not findings:
        return scenario
    findings.sort(key=file_order)
    raise ScenarioError(source, [Problem(_path(steps, single), text) for steps, text in findings])


def validated(scenario: Scenario) -> Scenario:
    """Return a scenario that was put together in Python if it is valid; raises ScenarioError."""
    parse_document(document_of(scenario), scenario.name)
    return scenario


def _path(steps: Steps, single_sensing: bool) -> str:
    if single_sensing and steps[:2] == ("sensing", 0):
        steps = ("sensing", *steps[2:])
    return written(steps)


def _loads(text: str, source: str, failure: type[DocumentError] = ScenarioError) -> Document:
    try:
        return tomllib.loads(text)
    except ValueError as error:  # names line and column
        raise failure(source, [Problem("", f"not TOML: {error}")]) from None
    except RecursionError:
        raise failure(source, [Problem("", "not TOML: nested too deeply")]) from None
