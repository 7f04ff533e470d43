"""Scenario files: TOML in, `Scenario` out, or every problem at once, each with its path; and back. Settings
modify a document: `control.k=80`, `robots[1].goal=[0, 0]`, `link.delay=[0.0, 0.3]`.

Positions in paths count from 0, in the order of the file: `robots[2].start` is the start of the third
`[[robots]]`. Robots are named by their ids: "overlaps robot 1".
"""

from __future__ import annotations

import copy
import json
import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import msgspec

from protocol.errors import DocumentError, Problem, ScenarioError
from protocol.scenario.body import PRESETS
from protocol.scenario.checks import checked
from protocol.scenario.model import Scenario
from protocol.scenario.tables import (
    Document,
    Step,
    Steps,
    file_order,
    keys_of,
    read_table,
    unknown_key,
    written,
)

_ALWAYS = ("name", "seed", "workspace", "time", "control")  # written even with default values
_STEP = re.compile(r"\.?([A-Za-z_][A-Za-z0-9_-]*)|\[(0|[1-9][0-9]{0,5})\]")


class _RefusedError(Exception):
    """One setting cannot be applied."""


def apply_settings(document: Document, settings: Iterable[str]) -> Document:
    """A copy of `document` with settings `path=VALUE` applied in order.

    Positions in arrays count from 0, as in error messages; the position after the last adds an element. A
    value is written as in TOML; a bare word is a string. Values are checked by the reader of the document,
    paths here.

    Raises ScenarioError if a setting is malformed or its path leads nowhere, with every problem of the rest.
    """
    changed = copy.deepcopy(document)
    problems: list[Problem] = []
    for setting in settings:
        path, equals, text = setting.partition("=")
        try:
            if not equals:
                raise _RefusedError("write path=VALUE, such as control.k=80")
            tried = copy.deepcopy(changed)
            _assign(tried, _steps(path.strip()), _parsed(text.strip()))
            changed = tried
        except _RefusedError as error:
            problems.append(Problem(path.strip(), str(error)))
    if problems:
        if "map" not in changed:  # which brings obstacles
            problems += _read(changed)[1]
        raise ScenarioError("scenario with settings (--set)", problems)
    return changed


def _steps(path: str) -> Steps:
    steps: list[Step] = []
    position = 0
    while position < len(path):
        found = _STEP.match(path, position)
        if found is None or (path[position] == "." and not steps):
            break
        steps.append(int(found[2]) if found[1] is None else found[1])
        position = found.end()
    if not steps or position < len(path):
        raise _RefusedError("a path is made of keys and positions, such as robots[1].goal")
    return tuple(steps)


def _parsed(text: str) -> Any:
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError) as error:
        if re.match(r"[\[{\"']", text) or not text or "\n" in text:
            raise _RefusedError(f"{text!r} is not a TOML value ({error})") from None
        return text
    if document.keys() != {"value"}:
        raise _RefusedError(f"{text!r} is more than one TOML value")
    return document["value"]


def _assign(document: Document, steps: Steps, value: Any) -> None:
    """Follow the path, adding missing tables and elements, and set the last step."""
    holder: Any = document
    gone: Steps = ()
    steps = _indexed(document, steps)
    for n, step in enumerate(steps):
        gone += (step,)
        absent, last = _absent(holder, step, gone), n == len(steps) - 1
        if last or absent:
            fresh = value if last else [] if isinstance(steps[n + 1], int) else {}
            if absent and isinstance(holder, list):
                holder.append(fresh)
            else:
                holder[step] = fresh
        holder = holder[step]


def _indexed(document: Document, steps: Steps) -> Steps:
    """`sensing.delay` means the one entry of `sensing`; `sensing` is an array from here on."""
    if steps[0] != "sensing" or len(steps) == 1:
        return steps
    sensing = document.setdefault("sensing", [{}])
    if isinstance(sensing, dict):
        document["sensing"] = sensing = [sensing]
    if isinstance(steps[1], int):
        return steps
    if isinstance(sensing, list) and len(sensing) > 1:
        raise _RefusedError(f"there are {len(sensing)} entries; say which one, such as sensing[0].{steps[1]}")
    return ("sensing", 0, *steps[1:])


def _absent(holder: Any, step: Step, gone: Steps) -> bool:
    """Whether `step` is still to be added to `holder`; refuses an invalid step."""
    parent = written(gone[:-1])
    if isinstance(step, int):
        if not isinstance(holder, list):
            raise _RefusedError(f"{parent} is not an array")
        if step > len(holder):
            raise _RefusedError(f"{parent} has {len(holder)} elements; positions count from 0")
        return step == len(holder)
    if not isinstance(holder, dict):
        raise _RefusedError(
            f"{parent} is an array: give a position, such as {parent}[0]"
            if isinstance(holder, list)
            else f"{parent} is not a table"
        )
    table = _table_at(gone[:-1])
    if table is None or step not in keys_of(table):
        raise _RefusedError(unknown_key(step, table) if table else f"{parent} has no keys")
    return step not in holder


def _table_at(steps: Steps) -> type | None:
    """The table at a path; None if it leads to a value or out of the document."""
    table: type | None = Scenario
    for step in steps:
        if isinstance(step, str) and table is not None:
            table = keys_of(table).get(step)
    return table


def read_document(path: Path | str, failure: type[DocumentError] = ScenarioError) -> Document:
    """Read a TOML file without checking its content; raises `failure` if that cannot be done."""
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
    """A scenario from plain tables, arrays and values; raises ScenarioError with every problem."""
    scenario, problems = _read(document)
    if problems:
        raise ScenarioError(source, problems)
    return scenario


def _read(document: Document) -> tuple[Scenario, list[Problem]]:
    """The scenario, which is only usable without problems."""
    single = isinstance(document.get("sensing"), dict)
    arrays = _with_radii(document | {"sensing": [document["sensing"]]} if single else document)
    scenario, findings = read_table(arrays, Scenario)
    findings += checked(scenario, {steps for steps, _ in findings})
    findings.sort(key=file_order(Scenario))
    return scenario, [Problem(_path(steps, single), text) for steps, text in findings]


def validated(scenario: Scenario) -> Scenario:
    """Return a scenario that was built in Python if it is valid; raises ScenarioError."""
    parse_document(document_of(scenario), scenario.name)
    return scenario


def _with_radii(document: Document) -> Document:
    """The document, with the radius of the body's disk for each robot without a radius, if there is one."""
    document = copy.deepcopy(document)
    robots, orders = (
        each if isinstance(each := document.get(key), list) else [] for key in ("robots", "orders")
    )
    for robot in (*robots, *(order.get("add") for order in orders if isinstance(order, dict))):
        if isinstance(robot, dict) and "radius" not in robot:
            radius = _disk_radius(robot.get("body", document.get("body")))
            if radius is not None:
                robot["radius"] = radius
    return document


def _disk_radius(body: Any) -> float | None:
    if isinstance(body, str) and body in PRESETS:
        return PRESETS[body].disk
    if isinstance(body, dict):
        hull, offset = body.get("radius"), body.get("offset", 0.0)
        if isinstance(hull, int | float) and isinstance(offset, int | float):
            return hull + offset
    return None


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


# -- and back


def document_of(scenario: Scenario) -> Document:
    """The scenario as plain tables, arrays and values, without defaults; robots come last."""
    document: Document = {}
    for field in fields(Scenario):
        value = getattr(scenario, field.name)
        if field.name in _ALWAYS and (
            field.name != "workspace" or scenario.map is None
        ):  # a map may bring it
            document[field.name] = _table(value, complete=True) if is_dataclass(value) else value
        elif value != field.default:
            document[field.name] = _plain(value)
    return {key: document[key] for key in (*(key for key in document if key != "robots"), "robots")}


def write_toml(scenario: Scenario) -> str:
    """The scenario as a TOML file; reading it back gives the same scenario, bit for bit.

    A library's writer puts each coordinate of a point on a line of its own.
    """
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
            yield f"{key} = {toml_value(value)}"
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


def toml_value(value: Any) -> str:
    """As it stands after `key =` in TOML."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{toml_value(key)} = {toml_value(item)}' for key, item in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):  # JSON's escapes are TOML's, but for the one control character JSON allows
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)


def json_schema() -> dict[str, Any]:
    """JSON schema of the scenario file, for editors; `sensing` may be one table or an array of them."""
    tables: dict[str, Any] = msgspec.json.schema(Scenario)["$defs"]
    for table in tables.values():
        if "properties" in table:
            table["properties"] = {key.rstrip("_"): value for key, value in table["properties"].items()}
            table["required"] = [key.rstrip("_") for key in table["required"]]
            table["additionalProperties"] = False
    top: dict[str, Any] = tables.pop("Scenario")
    top["properties"]["sensing"] = {"anyOf": [{"$ref": "#/$defs/Sensing"}, top["properties"]["sensing"]]}
    return {**top, "$defs": tables}
