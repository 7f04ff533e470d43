"""The page of scenario keys, from the model that reads scenario files."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from msgspec import Meta

from protocol.scenario import model
from protocol.scenario.tables import keys_of


def page() -> str:
    """As Markdown."""
    lines = [
        "# Scenario keys",
        "",
        "From the model that reads the files: metres, seconds, metres per second, radians. "
        "[How to write one](../guides/scenario.md).",
    ]
    for path, table in _tables("", model.Scenario):
        lines += ["", f"## {path or 'At the top'}", "", _meaning(table), ""]
        lines += ["| key | value | default | |", "|---|---|---|---|"]
        hints, comments = get_type_hints(table, include_extras=True), _comments(table)
        inner = {key for key, held in keys_of(table).items() if held is not None}
        for field in fields(table):
            key = field.name.rstrip("_")
            if key not in inner:
                kind = _kind(hints[field.name]).replace("|", "\\|")
                lines.append(f"| `{key}` | {kind} | {_default(field)} | {comments.get(field.name, '')} |")
    return "\n".join(lines) + "\n"


def _tables(path: str, table: type) -> Iterator[tuple[str, type]]:
    """Every table with its heading, depth first, in the order of the file."""
    yield path, table
    hints = get_type_hints(table, include_extras=True)
    for key, inner in keys_of(table).items():
        if inner is not None:
            steps = f"{path.strip('`[] ')}.{key}".lstrip(".")
            many = "tuple" in str(hints.get(key, hints.get(f"{key}_")))
            yield from _tables(f"`[[{steps}]]`" if many else f"`[{steps}]`", inner)


def _meaning(table: type) -> str:
    return " ".join((inspect.getdoc(table) or "").split())


def _comments(table: type) -> dict[str, str]:
    """What stands beside each field in the source."""
    found = re.findall(r"^    (\w+): .*?#\s*(.+)$", inspect.getsource(table), re.MULTILINE)
    return {name: text.replace("|", "\\|") for name, text in found}


def _default(field: Field[Any]) -> str:
    if field.default is MISSING:
        return "required"
    if field.default is None or field.default == ():
        return "none"
    return f"`{str(field.default).lower() if isinstance(field.default, bool) else field.default}`"


_PLAIN = {float: "number", int: "whole number", str: "text", bool: "true or false"}
_KNOWN = (
    (model.Span, "number ≥ 0, or [low, high]"),
    (model.Position, "[x, y]"),
    (model.Positive, "number > 0"),
    (model.Length, "number > 0"),
    (model.Gain, "number > 0"),
    (model.NonNegative, "number ≥ 0"),
    (model.Probability, "0 to 1"),
    (model.Coordinate, "number"),
    (model.RobotId, "id"),
)


def _kind(hint: Any) -> str:
    """A type with its range, in words."""
    for known, words in _KNOWN:
        if hint in (known, known | None):
            return words
    match get_origin(hint), get_args(hint):
        case origin, (inner, *bounds) if origin is Annotated:
            words = f"{_kind(inner)}{''.join(map(_bound, bounds))}"
        case origin, parts if origin is Literal:
            words = ", ".join(f'`"{part}"`' for part in parts)
        case origin, (inner, last) if origin is tuple and last is Ellipsis:
            words = f"array of {_kind(inner)}"
        case origin, parts if origin is tuple:
            words = f"[{', '.join(map(_kind, parts))}]"
        case _, ():
            words = _PLAIN.get(hint, str(hint))
        case _, parts:
            words = " or ".join(_kind(part) for part in parts if part is not NoneType)
    return words


def _bound(bound: Meta) -> str:
    words = "" if bound.ge is None else f" ≥ {bound.ge:g}"
    if bound.le is not None and bound.le < 2**53:
        words += f" ≤ {bound.le:g}"
    if bound.max_length is not None:
        words += f" of {bound.min_length or 0} to {bound.max_length}"
    elif bound.min_length is not None:
        words += f" of at least {bound.min_length}"
    return words
