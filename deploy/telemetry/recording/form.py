"""Messages as JSON objects: arrays of the wire get field names, and a JSON schema.

Derived from the declarations in `protocol.messages`. The schemas use only what Foxglove understands: a
property is a number, integer, string, object, or an array of one of these, never a union or an array of
arrays. So a vector becomes `{"x": .., "y": ..}`, and None is left out.

Each message has two twins, Structs of the same fields in which vectors and the like are Structs, too: one has
the form of the wire, the other encodes as a JSON object. msgspec converts one into the other.
"""

from __future__ import annotations

from functools import cache
from types import GenericAlias
from typing import Any, NamedTuple

import msgspec
from msgspec import inspect

from protocol.messages import VERSION, Message

_SCALARS: dict[type, tuple[str, type]] = {
    inspect.BoolType: ("boolean", bool),
    inspect.IntType: ("integer", int),
    inspect.FloatType: ("number", float),
    inspect.StrType: ("string", str),
    inspect.LiteralType: ("string", str),
}
_VECTOR = ("x", "y")


class Form(NamedTuple):
    """The forms of values of one type: JSON schema, and the types of the twins."""

    schema: dict[str, Any]
    wire: Any
    object: Any
    optional: bool = False  # whether the value may be None


def schema(message: type[Message]) -> dict[str, Any]:
    """JSON schema of a message's recorded form."""
    title = f"disknav.{message.__name__}/{VERSION}"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title} | _form(message).schema


def to_object(message: Message) -> Any:
    """An object that encodes as the recorded form of a message."""
    form = _form(type(message))
    twin = msgspec.convert(message, form.wire, from_attributes=True)
    return msgspec.convert(twin, form.object, from_attributes=True)


def from_json(message: type[Message], recorded: bytes) -> Message:
    """The message of a recorded form; raises msgspec.ValidationError if it is invalid."""
    form = _form(message)
    found = msgspec.json.decode(recorded, type=form.object)
    twin = msgspec.convert(found, form.wire, from_attributes=True)
    return msgspec.msgpack.decode(msgspec.msgpack.encode(twin), type=message)


@cache
def _form(struct: type[msgspec.Struct]) -> Form:
    described = inspect.type_info(struct)
    assert isinstance(described, inspect.StructType)
    fields = {field.name: _of(field.type) for field in described.fields}
    return _record(struct.__name__, fields, struct.__struct_config__.tag)


def _of(described: inspect.Type) -> Form:
    names = _VECTOR
    if isinstance(described, inspect.Metadata):
        names, described = (described.extra or {}).get("names", names), described.type
    match described:
        case inspect.UnionType():
            (present,) = (each for each in described.types if not isinstance(each, inspect.NoneType))
            form = _of(present)
            return Form(form.schema, form.wire | None, form.object | None, optional=True)
        case inspect.VarTupleType():
            item = _of(described.item_type)
            schema = {"type": "array", "items": item.schema}
            return Form(schema, GenericAlias(list, item.wire), GenericAlias(list, item.object))
        case inspect.TupleType():
            return _record("_".join(names), dict(zip(names, map(_of, described.item_types), strict=True)))
        case inspect.DictType():
            value = _of(described.value_type)
            schema = {"type": "object", "properties": {}, "additionalProperties": value.schema}
            return Form(
                schema, GenericAlias(dict, (str, value.wire)), GenericAlias(dict, (str, value.object))
            )
        case inspect.StructType():
            return _form(described.cls)
    name, scalar = _SCALARS[type(described)]
    return Form({"type": name}, scalar, scalar)


def _record(name: str, fields: dict[str, Form], tag: Any = None) -> Form:
    properties = {each: field.schema for each, field in fields.items()}
    required = [each for each, field in fields.items() if not field.optional]
    wire = [(each, field.wire) for each, field in fields.items()]
    objects = [(each, field.object, *(None,) * field.optional) for each, field in fields.items()]
    return Form(
        {"type": "object", "properties": properties, "required": required},
        msgspec.defstruct(name, wire, array_like=True, tag=tag, gc=False),
        msgspec.defstruct(name, objects, kw_only=True, omit_defaults=True, gc=False),
    )
