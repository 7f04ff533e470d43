"""Settings laid over a document: `control.k=80`, `robots[1].goal=[0, 0]`, `link.delay=[0.0, 0.3]`."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable
from typing import Any

from protocol.errors import Problem, ScenarioError
from protocol.scenario.model import Scenario
from protocol.scenario.tables import Document, Step, Steps, keys_of, unknown_key, written

_STEP = re.compile(r"\.?([A-Za-z_][A-Za-z0-9_-]*)|\[(0|[1-9][0-9]{0,5})\]")


class _RefusedError(Exception):
    """One setting cannot be applied."""


def apply_settings(document: Document, settings: Iterable[str]) -> Document:
    """A copy of `document` with settings `path=VALUE` applied in order.

    Positions in arrays count from 0, as in error messages; the position after the last adds an element.
    A value is written as in TOML; a bare word is taken as a string. Values are checked by the reader of
    the document, paths are checked here.

    Raises:
        ScenarioError: a setting is malformed, or its path leads nowhere; names all of them.
    """
    changed = copy.deepcopy(document)
    problems: list[Problem] = []
    for setting in settings:
        path, equals, text = setting.partition("=")
        try:
            if not equals:
                raise _RefusedError("write path=VALUE, such as control.k=80")
            _assign(changed, _steps(path.strip()), _parsed(text.strip()))
        except _RefusedError as error:
            problems.append(Problem(path.strip(), str(error)))
    if problems:
        raise ScenarioError("--set", problems)
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
    """Go down, adding tables and elements that are not there, and set the last step."""
    holder: Any = document
    gone: Steps = ()
    steps = _indexed(document, steps)
    for n, step in enumerate(steps):
        gone += (step,)
        absent = _absent(holder, step, gone)
        if n == len(steps) - 1:
            fresh = value
        elif absent:
            fresh = [] if isinstance(steps[n + 1], int) else {}
        else:
            holder = holder[step]
            continue
        if isinstance(holder, list) and absent:
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
    """Whether `step` is still to be added to `holder`; refuses a step that leads nowhere."""
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
    """The table that a path leads to, None where the path leads to a value or out of the document."""
    table: type | None = Scenario
    for step in steps:
        if isinstance(step, str) and table is not None:
            table = keys_of(table).get(step)
    return table
