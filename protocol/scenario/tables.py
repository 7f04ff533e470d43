"""Plain tables, as of TOML, become dataclasses; otherwise all their errors are listed.

Keys, types and ranges are those of the dataclasses; a trailing underscore avoids a Python keyword (`from_` is
`from` in a file). Strict: no number is read from a string, and a truth value is not a number.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields, is_dataclass
from datetime import date, time
from difflib import get_close_matches
from functools import cache
from math import isfinite, nan
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta

Step = str | int  # a key of a table, or a position in an array, from 0
Steps = tuple[Step, ...]
Mistake = tuple[Steps, str]  # something wrong, and where
Document = dict[str, Any]  # a parsed TOML file

_Table = TypeVar("_Table")
_KINDS: dict[object, str] = {
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    str: "a string",
    tuple: "an array",
}


def read_table(document: Document, table: type[_Table]) -> tuple[_Table, list[Mistake]]:
    """A document as `table`, and all errors of its keys, types and ranges.

    Malformed values become NaN, 0, "", False, None where allowed, an empty array, or a table of these.
    """
    findings: list[Mistake] = []
    found: _Table = _table((), document, table, findings)
    return found, findings


def _value(steps: Steps, value: Any, hint: Any, findings: list[Mistake]) -> Any:
    kinds, metas = _alternatives(hint)
    if value is None and NoneType in kinds:
        return None
    for kind, own in kinds.items():
        if _is_table(kind) and isinstance(value, dict):
            return _table(steps, value, kind, findings)
        if get_origin(kind) is tuple and isinstance(value, list):
            return _array(steps, value, kind, own, findings)
    if problem := _wrong(value, kinds, metas):
        findings.append((steps, problem))
        return _nothing(hint)
    return msgspec.convert(value, hint)


def _table(steps: Steps, value: Document, table: Any, findings: list[Mistake]) -> Any:
    hints, known = _hints(table), keys_of(table)
    read: dict[str, Any] = {}
    for key in value:
        if key not in known:
            shown = key if isinstance(key, str) and _is_unicode(key) else "?"
            findings.append(((*steps, shown), unknown_key(shown, table)))
    for field in fields(table):
        key, hint = field.name.rstrip("_"), hints[field.name]
        if key in value:
            read[field.name] = _value((*steps, key), value[key], hint, findings)
        elif field.default is MISSING:
            findings.append(((*steps, key), "is missing"))
            read[field.name] = _nothing(hint)
    return table(**read)


def _array(steps: Steps, value: list[Any], kind: Any, metas: Sequence[Meta], findings: list[Mistake]) -> Any:
    inner = get_args(kind)
    if inner[-1] is not Ellipsis:
        if len(value) != len(inner):
            findings.append((steps, f"must have {len(inner)} elements, has {len(value)}"))
            return _nothing(kind)
        each = zip(value, inner, strict=True)
    else:
        for meta in metas:
            if meta.max_length is not None and len(value) > meta.max_length:
                findings.append((steps, f"must have at most {meta.max_length} elements, has {len(value)}"))
                return ()
            if meta.min_length is not None and not value:
                findings.append((steps, "must not be empty"))
        each = zip(value, [inner[0]] * len(value), strict=True)
    return tuple(_value((*steps, n), item, hint, findings) for n, (item, hint) in enumerate(each))


def _wrong(value: Any, kinds: dict[Any, tuple[Meta, ...]], metas: Sequence[Meta]) -> str:
    """The reason why a value is none of these alternatives, which are neither its table nor its array."""
    leaves = [kind for kind in kinds if kind is not NoneType]
    kind = next((kind for kind in leaves if _is_of(value, kind)), None)
    if kind is None:
        hint = next((meta.description for meta in metas if meta.description), None)
        return f"must be {hint or _named(leaves)}, not {_described(value)}"
    if kind is float and not (isfinite(value) if isinstance(value, float) else abs(value) < 2**63):
        return "must be a finite number of reasonable size"
    for meta in kinds[kind]:
        if meta.ge is not None and value < meta.ge:
            return f"must be at least {meta.ge:g}, is {_described(value)}"
        if meta.le is not None and value > meta.le:
            return f"must be at most {meta.le:g}, is {_described(value)}"
    try:
        msgspec.convert(value, Annotated[kind, *kinds[kind]] if kinds[kind] else kind)
    except msgspec.ValidationError:
        return next(f"must be {meta.description}" for meta in kinds[kind] if meta.description)
    return ""


def _is_of(value: Any, kind: Any) -> bool:
    """Whether a value is of a type, whatever its range."""
    if get_origin(kind) is Literal:
        return isinstance(value, str) and value in get_args(kind)
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if kind is str:
        return isinstance(value, str) and _is_unicode(value)
    return type(value) is kind and not (kind is int and abs(value) >= 2**63)


def _nothing(hint: Any) -> Any:
    kinds, _ = _alternatives(hint)
    if NoneType in kinds:
        return None
    kind = next(iter(kinds))
    if _is_table(kind):
        inner = _hints(kind)
        return kind(**{field.name: _nothing(inner[field.name]) for field in fields(kind)})
    if get_origin(kind) is tuple:
        inner_kinds = get_args(kind)
        return () if inner_kinds[-1] is Ellipsis else tuple(map(_nothing, inner_kinds))
    return "" if get_origin(kind) is Literal else {float: nan, int: 0, bool: False}.get(kind, "")


@cache  # called 10 000 times for a scenario of 1000 robots
def _alternatives(hint: Any) -> tuple[dict[Any, tuple[Meta, ...]], tuple[Meta, ...]]:
    """The alternatives of a type annotation, each with its ranges; and their common description."""
    metas: tuple[Meta, ...] = ()
    if get_origin(hint) is Annotated:
        hint, *extra = get_args(hint)
        metas = tuple(extra)
    if get_origin(hint) not in (Union, UnionType):
        return {hint: metas}, metas
    kinds: dict[Any, tuple[Meta, ...]] = {}
    for each in get_args(hint):
        kinds |= _alternatives(each)[0]
    return kinds, metas


@cache
def _hints(table: Any) -> dict[str, Any]:
    return get_type_hints(table, include_extras=True)


def _named(kinds: Iterable[Any]) -> str:
    names: list[str] = []
    for kind in kinds:
        if get_origin(kind) is Literal:
            words = list(map(repr, get_args(kind)))
            names.append(" or ".join(filter(None, [", ".join(words[:-1]), words[-1]])))
        else:
            names.append("a table" if _is_table(kind) else _KINDS[get_origin(kind) or kind])
    return " or ".join(names)


def _described(value: Any) -> str:
    """A value as users would name it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str) and not _is_unicode(value):
        return "text that is not Unicode"
    if isinstance(value, str):
        return f"the string {json.dumps(value[:40], ensure_ascii=False)}"
    if isinstance(value, int | float):
        return f"{value:g}" if isinstance(value, float) or abs(value) < 10**6 else "a huge number"
    if isinstance(value, date | time):
        return "a date or time"
    return "an array" if isinstance(value, list) else "a table" if isinstance(value, dict) else "nothing"


def _is_unicode(text: str) -> bool:
    """Whether `text` consists of whole characters, unlike an argument in another encoding."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


# -- keys and paths


@cache
def keys_of(table: Any) -> dict[str, type | None]:
    """Keys of a table in the file's order, each with its table (or array of tables)."""
    hints = _hints(table)
    return {field.name.rstrip("_"): _table_in(hints[field.name]) for field in fields(table)}


def _is_table(kind: Any) -> bool:
    return is_dataclass(kind)


def _table_in(hint: Any) -> type | None:
    """The dataclass inside a type annotation, such as `RobotSpec` in `tuple[RobotSpec, ...]`."""
    if isinstance(hint, type) and is_dataclass(hint):
        return hint
    return next((found for part in get_args(hint) if (found := _table_in(part)) is not None), None)


def file_order(table: type) -> Any:
    """A key that sorts findings by their places in a file; unknown keys come first."""
    top = list(keys_of(table))

    def key(finding: Mistake) -> tuple[int, tuple[tuple[int, str], ...]]:
        steps, _ = finding
        rank = top.index(str(steps[0])) if steps and steps[0] in top else -1
        return rank, tuple((step, "") if isinstance(step, int) else (-1, step) for step in steps[1:])

    return key


def written(steps: Iterable[Step]) -> str:
    """A path as users write it: `robots[2].start`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    return text.removeprefix(".")


def unknown_key(key: str, table: type) -> str:
    """Text for a key that `table` does not have: near ones, also of tables inside, or all if none is near."""
    known = keys_of(table)
    inside = [f"{name}.{key}" for name, inner in known.items() if inner is not None and key in keys_of(inner)]
    if near := get_close_matches(key, known, 1, 0.9 if inside else 0.5) + inside:
        return f"unknown key; did you mean {' or '.join(f'`{each}`' for each in near)}?"
    return f"unknown key; known are {', '.join(f'`{name}`' for name in known)}"
