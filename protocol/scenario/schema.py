"""Types, ranges and keys: a plain document becomes a `Scenario`, or every problem is named.

Other files that people write are read by the same words: any dataclass that is declared as `Scenario` is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from datetime import date, time
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar

from protocol.scenario.body import PRESETS
from protocol.scenario.model import Scenario
from protocol.scenario.shape import Document, Finding, Step, Steps, table_at, unknown_key

if TYPE_CHECKING:
    from pydantic import TypeAdapter
    from pydantic_core import ErrorDetails

_Table = TypeVar("_Table")
_EITHER: dict[Step, str] = {
    "delay": "must be a number of seconds or an array [low, high]",
    "k": 'must be a number, "auto" or "certified"',
    "body": f"must be a table or one of {', '.join(PRESETS)}",
}
_KINDS = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "string_type": "a string",
    "tuple_type": "an array",
    "dataclass_type": "a table",
    "literal_error": "one of the known words",
}
_KEY_ERRORS = ("missing", "unexpected_keyword_argument")
_BOUNDS = {
    "greater_than_equal": ("ge", "at least"),
    "less_than_equal": ("le", "at most"),
}
_OTHERS = {"finite_number": "must be a finite number of reasonable size"}


@cache
def _adapter(table: type) -> TypeAdapter[Any]:
    from pydantic import TypeAdapter  # only whoever reads a scenario pays for it

    return TypeAdapter(table)


def json_schema() -> dict[str, Any]:
    """JSON schema of the scenario file, for editors; `sensing` may be one table or an array of them."""
    schema = _adapter(Scenario).json_schema()
    sensing = schema["properties"]["sensing"]
    schema["properties"]["sensing"] = {"anyOf": [{"$ref": "#/$defs/Sensing"}, sensing]}
    return schema


def typed(document: Document, table: type[_Table]) -> tuple[_Table | None, list[Finding]]:
    """Check types, ranges and keys of `table`; what was read, or None and everything that is wrong.

    Strict: no number is read from a string, and a truth value is not a number.
    """
    from pydantic import ValidationError

    root: type = table
    try:
        found: _Table = _adapter(root).validate_json(json.dumps(_plain(document)), strict=True)
        return found, []
    except ValidationError as error:
        return None, _findings(document, error.errors(include_url=False), table)


def _plain(value: Any) -> Any:
    """`value` as JSON has it; what JSON cannot say becomes something that no field accepts."""
    match value:
        case dict():
            return {key if _is_unicode(key) else "?": _plain(item) for key, item in value.items()}
        case list():
            return [_plain(item) for item in value]
        case date() | time():
            return False
        case int() if abs(value) >= 2**63:
            return math.inf
        case str() if not _is_unicode(value):
            return False
    return value


def _is_unicode(text: str) -> bool:
    """Whether `text` is whole characters: a setting from a command line in another encoding is not."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


def _findings(document: Document, errors: Sequence[ErrorDetails], table: type) -> list[Finding]:
    """What to say, one text per place: of a union, only the alternative that was meant is heard."""
    found: dict[Steps, str] = {}
    rejected: dict[Steps, Any] = {}  # unions, with the value that was given
    for error in errors:
        steps, value, union = _locate(document, error["loc"], error["type"] in _KEY_ERRORS)
        if steps == union and error["type"] in _KINDS:
            rejected[union] = value
        elif text := _text(error, steps, value, table):
            found.setdefault(steps, text)
    for union, value in rejected.items():
        if not any(steps[: len(union)] == union for steps in found):
            found[union] = f"{_EITHER[union[-1]]}, not {_described(value)}"
    return list(found.items())


def _locate(document: Document, location: Steps, of_key: bool) -> tuple[Steps, Any, Steps | None]:
    """Steps of an error in the document, the value there, and the union it lies in; `of_key`: the last step
    is a key that a table lacks, or should lack.

    pydantic puts the name of a union's alternative into the location: a step that the document lacks.
    """
    steps: Steps = ()
    value: Any = document
    union: Steps | None = None
    for n, step in enumerate(location):
        last = n == len(location) - 1
        if isinstance(value, dict) and (step in value or (last and of_key)):
            value = value.get(step)
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        elif isinstance(step, int):
            continue  # an element that is missing: the array is too short
        else:
            union = steps
            continue
        steps += (step,)
    return steps, value, union


def _text(error: ErrorDetails, steps: Steps, value: Any, table: type) -> str:
    """One error of pydantic in this project's words; empty when it only follows from others."""
    kind, context = error["type"], error.get("ctx", {})
    if kind in _BOUNDS:
        name, words = _BOUNDS[kind]
        text = f"must be {words} {context[name]:g}, is {_described(value)}"
    elif kind == "missing":
        text = f"must have 2 elements, has {len(value)}" if isinstance(value, list) else "is missing"
    elif kind == "unexpected_keyword_argument":
        text = unknown_key(str(steps[-1]), table_at(steps[:-1], table) or table)
    elif kind == "too_long":
        text = f"must have at most {context['max_length']} elements, has {len(value)}"
    elif kind == "too_short":
        text = "" if value else "must not be empty"
    elif kind in _KINDS:
        text = f"must be {context.get('expected', _KINDS[kind])}, not {_described(value)}"
    else:
        text = _OTHERS.get(kind, error["msg"])
    return text


def _described(value: Any) -> str:
    """A value as people would name it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str) and not _is_unicode(value):
        return "text that is not Unicode"
    if isinstance(value, str):
        return f"the string {json.dumps(value[:40], ensure_ascii=False)}"
    if isinstance(value, int | float):
        return f"{value:g}" if isinstance(value, float) or abs(value) < 10**6 else "a huge number"
    names: dict[type, str] = {list: "an array", dict: "a table"}
    return names.get(type(value), "a date or time")
