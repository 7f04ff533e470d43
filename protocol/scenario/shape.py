"""The shape of a scenario file: which keys its tables know. Derived from `protocol.scenario.model`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any, get_args, get_type_hints

from protocol.scenario.model import Scenario

Step = str | int  # a key of a table, or a position in an array, from 0
Steps = tuple[Step, ...]
Finding = tuple[Steps, str]  # something wrong, and where
Document = dict[str, Any]  # what tomllib makes of a file


@cache
def keys_of(table: type) -> dict[str, type | None]:
    """Keys of a table in the file's order, each with the table (or array of tables) that it holds."""
    hints = get_type_hints(table, include_extras=True)
    return {field.name.rstrip("_"): _table_in(hints[field.name]) for field in fields(table)}


def table_at(steps: Iterable[Step], root: type = Scenario) -> type | None:
    """The table that a path leads to, None where the path leads to a value or out of the document."""
    table: type | None = root
    for step in steps:
        if isinstance(step, str) and table is not None:
            table = keys_of(table).get(step)
    return table


def file_order(finding: Finding) -> tuple[int, tuple[tuple[int, str], ...]]:
    """Sorts findings as their places stand in a file; keys that nobody knows come first."""
    steps, _ = finding
    top = list(keys_of(Scenario))
    rank = top.index(str(steps[0])) if steps and steps[0] in top else -1
    return rank, tuple((step, "") if isinstance(step, int) else (-1, step) for step in steps[1:])


def written(steps: Iterable[Step]) -> str:
    """A path as people write it: `robots[2].start`."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps)
    return text.removeprefix(".")


def unknown_key(key: str, table: type) -> str:
    """What to say of a key that `table` does not know."""
    return f"unknown key; {suggestion(key, list(keys_of(table)))}"


def suggestion(word: str, known: Sequence[str]) -> str:
    """The known word that is nearest to `word`, or all of them where none is near."""
    near = get_close_matches(word, known, 1, 0.5)
    return f"did you mean `{near[0]}`?" if near else f"known are {', '.join(f'`{name}`' for name in known)}"


def _table_in(hint: Any) -> type | None:
    """The dataclass inside a type annotation, such as `RobotSpec` in `tuple[RobotSpec, ...]`."""
    if isinstance(hint, type) and is_dataclass(hint):
        return hint
    return next((found for part in get_args(hint) if (found := _table_in(part)) is not None), None)
