"""A scenario as TOML text. Reading it back gives the same scenario, bit for bit."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from protocol.scenario.model import Scenario, Sensing
from protocol.scenario.shape import Document

_ALWAYS = ("workspace", "time", "control")  # written even where they say what holds anyway


def document_of(scenario: Scenario) -> Document:
    """The scenario as plain tables, arrays and values, leaving out what holds anyway."""
    document: Document = {"name": scenario.name}
    if scenario.description:
        document["description"] = scenario.description
    document["seed"] = scenario.seed
    for key in _ALWAYS:
        document[key] = _table(getattr(scenario, key), complete=True)
    if scenario.sensing != (Sensing(),):
        document["sensing"] = [_table(sensing) for sensing in scenario.sensing]
    for key in ("link", "network", "process", "actuation", "world", "things", "parts", "carrying", "orders"):
        if value := _plain(getattr(scenario, key)):
            document[key] = value
    if scenario.body != "point":
        document["body"] = _plain(scenario.body)
    if scenario.base is not None:
        document["base"] = _plain(scenario.base)
    document["robots"] = _plain(scenario.robots)
    return document


def write_toml(scenario: Scenario) -> str:
    """The scenario as a TOML file."""
    document = document_of(scenario)
    if len(document.get("sensing", ())) == 1:
        document["sensing"] = document["sensing"][0]
    return "\n".join(_lines((), document)).lstrip("\n") + "\n"


def _table(value: Any, *, complete: bool = False) -> Document:
    """One dataclass; fields that have their default are left out unless `complete`."""
    items = {field: getattr(value, field.name) for field in fields(value)}
    return {
        field.name.rstrip("_"): _plain(item)
        for field, item in items.items()
        if item is not None and (complete or item != field.default)
    }


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return _table(value)
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value


def _lines(path: tuple[str, ...], table: Document) -> Iterator[str]:
    """A table's own values first, then its tables: TOML allows no other order."""
    for key, value in table.items():
        if not _holds_tables(value):
            yield f"{key} = {_value(value)}"
    for key, value in table.items():
        inner = (*path, key)
        if isinstance(value, dict):
            yield f"\n[{'.'.join(inner)}]"
            yield from _lines(inner, value)
        elif _holds_tables(value):
            for item in value:
                yield f"\n[[{'.'.join(inner)}]]"
                yield from _lines(inner, item)


def _holds_tables(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):  # JSON's escapes are TOML's, but for the one control character JSON allows
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
