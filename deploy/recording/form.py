"""Messages as JSON objects: what is an array on the wire gets its field names, and a JSON schema.

Derived from the declarations in `protocol.messages`. The schemas keep to what Foxglove understands:
a property is a number, integer, string, object, or an array of one of these, never a union and never
an array of arrays. So a vector becomes `{"x": .., "y": ..}`, and what is None is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import msgspec
from msgspec import inspect

from protocol.messages import VERSION, Message

Content = dict[str, Any]

_SCALARS: dict[type, str] = {
    inspect.BoolType: "boolean",
    inspect.IntType: "integer",
    inspect.FloatType: "number",
    inspect.StrType: "string",
}
_VECTOR = ("x", "y")
_NONE: Mapping[str, Any] = MappingProxyType({})


class Form(NamedTuple):
    """How values of one type look in JSON.

    `to_json` turns a Python expression for a value into one for its JSON form: expressions are put
    together and compiled once a type, which is three times as fast as calls that nest, and decides
    what recording costs. `from_json` gives back the wire's value, tags left out.
    """

    schema: dict[str, Any]
    to_json: Callable[[str], str] = lambda value: value
    from_json: Callable[[Any], Any] = lambda value: value
    optional: bool = False


def schema(message: type[Message]) -> dict[str, Any]:
    """JSON schema of a message's recorded form."""
    title = f"disknav.{message.__name__}/{VERSION}"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title} | _form(message).schema


@cache
def to_object(message: type[Message]) -> Callable[[Message], Content]:
    """What turns messages of this type into their recorded form."""
    expression = _form(message).to_json("message")
    change: Callable[[Message], Content] = eval(f"lambda message: {expression}")  # see Form
    return change


def from_object(message: type[Message], content: Content) -> Message:
    """The message that `content` is the recorded form of.

    Raises:
        KeyError, msgspec.ValidationError: it is none.
    """
    return msgspec.convert([message.__struct_config__.tag, *_form(message).from_json(content)], type=message)


@cache
def _form(message: type[msgspec.Struct]) -> Form:
    described = inspect.type_info(message)
    assert isinstance(described, inspect.StructType)
    fields = {field.name: _of(field.type) for field in described.fields}
    # A recording from before a field was added is still read.
    defaults = {field.name: field.default for field in described.fields if not field.required}
    return _record(fields, "{value}.{name}", defaults)


def _of(described: inspect.Type) -> Form:
    """The form of a declared type."""
    match described:
        case inspect.Metadata():
            return _named(described)
        case inspect.UnionType():
            return _optional(described)
        case inspect.VarTupleType():
            return _array(_of(described.item_type))
        case inspect.TupleType():
            return _tuple(described, _VECTOR)
        case inspect.DictType():
            values = _of(described.value_type).schema
            return Form({"type": "object", "properties": {}, "additionalProperties": values})
    return _form(described.cls) if isinstance(described, inspect.StructType) else _scalar(described)


def _scalar(described: inspect.Type) -> Form:
    return Form({"type": _SCALARS[type(described)]})


def _named(described: inspect.Metadata) -> Form:
    """A tuple whose elements have names of their own."""
    names = (described.extra or {}).get("names")
    if names is None or not isinstance(described.type, inspect.TupleType):
        return _of(described.type)
    return _tuple(described.type, names)


def _tuple(described: inspect.TupleType, names: tuple[str, ...]) -> Form:
    fields = dict(zip(names, map(_of, described.item_types), strict=True))
    return _record(fields, "{value}[{index}]")


def _optional(described: inspect.UnionType) -> Form:
    (present,) = (option for option in described.types if not isinstance(option, inspect.NoneType))
    return _of(present)._replace(optional=True)


def _array(item: Form) -> Form:
    inner = item.to_json("item")
    return Form(
        {"type": "array", "items": item.schema},
        lambda value: value if inner == "item" else f"[{inner} for item in {value}]",
        lambda values: [item.from_json(value) for value in values],
    )


def _record(fields: dict[str, Form], access: str, defaults: Mapping[str, Any] = _NONE) -> Form:
    """An object with one property a field; `access` says how a field is reached from its owner."""

    def to_json(value: str) -> str:
        parts = []
        for index, (name, field) in enumerate(fields.items()):
            inner = access.format(value=value, name=name, index=index)
            part = f'"{name}": {field.to_json(inner)}'
            parts.append(f"**({{}} if {inner} is None else {{{part}}})" if field.optional else part)
        return f"{{{', '.join(parts)}}}"

    def from_json(content: Content) -> list[Any]:
        return [
            absent[name] if name in absent and name not in content else field.from_json(content[name])
            for name, field in fields.items()
        ]

    absent = {name: None for name, field in fields.items() if field.optional} | dict(defaults)
    properties = {name: field.schema for name, field in fields.items()}
    required = [name for name, field in fields.items() if not field.optional]
    return Form({"type": "object", "properties": properties, "required": required}, to_json, from_json)
