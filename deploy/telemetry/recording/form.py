"""Messages as JSON objects: what is an array on the wire gets its field names, and a JSON schema.

Derived from the declarations in `protocol.messages`. The schemas keep to what Foxglove understands:
a property is a number, integer, string, object, or an array of one of these, never a union and never
an array of arrays. So a vector becomes `{"x": .., "y": ..}`, and what is None is left out.

A message is copied into Structs of the same fields that JSON takes for objects: they are made and
encoded in a third of the time of dictionaries.
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
    inspect.LiteralType: "string",
}
_VECTOR = ("x", "y")
_NONE: Mapping[str, Any] = MappingProxyType({})


class Form(NamedTuple):
    """How values of one type look in JSON.

    `to_json` turns a Python expression for a value into one for its JSON form: expressions are put
    together and compiled once a type, which is three times as fast as calls that nest, and decides
    what recording costs. `objects` are the types that they name. `from_json` gives back the wire's
    value, tags left out.
    """

    schema: dict[str, Any]
    to_json: Callable[[str], str] = lambda value: value
    objects: Mapping[str, type[msgspec.Struct]] = _NONE
    from_json: Callable[[Any], Any] = lambda value: value
    optional: bool = False


def schema(message: type[Message]) -> dict[str, Any]:
    """JSON schema of a message's recorded form."""
    title = f"disknav.{message.__name__}/{VERSION}"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title} | _form(message).schema


@cache
def to_object(message: type[Message]) -> Callable[[Message], msgspec.Struct]:
    """What turns messages of this type into what JSON writes their recorded form of."""
    form = _form(message)
    names = {"UNSET": msgspec.UNSET, **form.objects}
    change: Callable[[Message], msgspec.Struct] = eval(f"lambda message: {form.to_json('message')}", names)
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
    return _record(message.__name__, fields)


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
    return _nested(described.cls) if isinstance(described, inspect.StructType) else _scalar(described)


def _nested(cls: type[msgspec.Struct]) -> Form:
    """A Struct in a field; where it is a message, it has its tag on the wire there, too."""
    form, tag = _form(cls), cls.__struct_config__.tag
    return form if tag is None else form._replace(from_json=lambda value: [tag, *form.from_json(value)])


def _scalar(described: inspect.Type) -> Form:
    return Form({"type": _SCALARS[type(described)]})


def _named(described: inspect.Metadata) -> Form:
    """A tuple whose elements have names of their own."""
    names = (described.extra or {}).get("names")
    if names is None or not isinstance(described.type, inspect.TupleType):
        return _of(described.type)
    return _tuple(described.type, names)


def _tuple(described: inspect.TupleType, names: tuple[str, ...]) -> Form:
    """Of numbers or strings."""
    name = "_".join(names)
    record = _record(name, dict(zip(names, map(_scalar, described.item_types), strict=True)))
    return record._replace(to_json=lambda value: f"{name}(*{value})")


def _optional(described: inspect.UnionType) -> Form:
    (present,) = (option for option in described.types if not isinstance(option, inspect.NoneType))
    form = _of(present)
    # JSON leaves out what is unset.
    return form._replace(
        to_json=lambda value: f"(UNSET if {value} is None else {form.to_json(value)})", optional=True
    )


def _array(item: Form) -> Form:
    inner = item.to_json("item")
    return Form(
        {"type": "array", "items": item.schema},
        # None is there as a rule, and then there is nothing to go through.
        lambda value: value if inner == "item" else f"({value} and [{inner} for item in {value}])",
        item.objects,
        lambda values: [item.from_json(value) for value in values],
    )


def _record(name: str, fields: dict[str, Form]) -> Form:
    """An object with one property a field."""

    def to_json(value: str) -> str:
        parts = (field.to_json(f"{value}.{each}") for each, field in fields.items())
        return f"{name}({', '.join(parts)})"

    def from_json(content: Content) -> list[Any]:
        return [
            None if field.optional and each not in content else field.from_json(content[each])
            for each, field in fields.items()
        ]

    properties = {each: field.schema for each, field in fields.items()}
    required = [each for each, field in fields.items() if not field.optional]
    objects = {name: _object(name, tuple(fields))}
    for field in fields.values():
        objects |= field.objects
    schema = {"type": "object", "properties": properties, "required": required}
    return Form(schema, to_json, objects, from_json)


@cache
def _object(name: str, fields: tuple[str, ...]) -> type[msgspec.Struct]:
    return msgspec.defstruct(name, fields, gc=False)
