"""Messages as JSON objects: arrays of the wire get field names, and a JSON schema.

Derived from the declarations in `protocol.messages`. The schemas use only what Foxglove understands: a
property is a number, integer, string, object, or an array of one of these, never a union or an array of
arrays. So a vector becomes `{"x": .., "y": ..}`, and None is left out.

A message is copied into Structs of the same fields that encode as JSON objects, which takes a third of the
time of dictionaries.
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
    """The JSON form of values of one type.

    Attributes:
        schema: JSON schema.
        to_json: turns a Python expression of a value into one of its JSON form. The expressions of a type are
            joined and compiled once, which is three times as fast as nested calls.
        objects: the types named in these expressions.
        from_json: inverse, to the wire's value without tags.
        optional: whether the value may be None.
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
    """Function that turns messages of this type into objects that encode as their recorded form."""
    form = _form(message)
    names = {"UNSET": msgspec.UNSET, **form.objects}
    change: Callable[[Message], msgspec.Struct] = eval(f"lambda message: {form.to_json('message')}", names)
    return change


def from_object(message: type[Message], content: Content) -> Message:
    """The message with the recorded form `content`.

    Raises:
        KeyError, msgspec.ValidationError: it is invalid.
    """
    return msgspec.convert([message.__struct_config__.tag, *_form(message).from_json(content)], type=message)


@cache
def _form(message: type[msgspec.Struct]) -> Form:
    described = inspect.type_info(message)
    assert isinstance(described, inspect.StructType)
    fields = {field.name: _of(field.type) for field in described.fields}
    return _record(message.__name__, fields)


def _of(described: inspect.Type) -> Form:
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
    """A Struct in a field; a message has its tag on the wire there, too."""
    form, tag = _form(cls), cls.__struct_config__.tag
    return form if tag is None else form._replace(from_json=lambda value: [tag, *form.from_json(value)])


def _scalar(described: inspect.Type) -> Form:
    return Form({"type": _SCALARS[type(described)]})


def _named(described: inspect.Metadata) -> Form:
    names = (described.extra or {}).get("names")
    if names is None or not isinstance(described.type, inspect.TupleType):
        return _of(described.type)
    return _tuple(described.type, names)


def _tuple(described: inspect.TupleType, names: tuple[str, ...]) -> Form:
    name = "_".join(names)
    record = _record(name, dict(zip(names, map(_scalar, described.item_types), strict=True)))
    return record._replace(to_json=lambda value: f"{name}(*{value})")


def _optional(described: inspect.UnionType) -> Form:
    (present,) = (option for option in described.types if not isinstance(option, inspect.NoneType))
    form = _of(present)
    # JSON omits unset fields.
    return form._replace(
        to_json=lambda value: f"(UNSET if {value} is None else {form.to_json(value)})", optional=True
    )


def _array(item: Form) -> Form:
    inner = item.to_json("item")
    return Form(
        {"type": "array", "items": item.schema},
        # Most arrays are empty: skip the loop.
        lambda value: value if inner == "item" else f"({value} and [{inner} for item in {value}])",
        item.objects,
        lambda values: [item.from_json(value) for value in values],
    )


def _record(name: str, fields: dict[str, Form]) -> Form:
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
