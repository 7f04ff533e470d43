"""Whether numbers keep to the ranges that their annotations state, where no file was read that says so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import is_dataclass
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from annotated_types import Ge, Le, Len


def out_of_range(value: object, name: str = "") -> Iterator[str]:
    """What of a dataclass, and of those in it, is not within its range: `body.hold: must be at least 0`.

    Types are taken for right; a number that is none is in no range.
    """
    for key, hint in get_type_hints(type(value), include_extras=True).items():
        if not key.startswith("_"):
            yield from _wrong(hint, getattr(value, key), f"{name}.{key}".lstrip("."))


def _wrong(hint: Any, value: Any, name: str) -> Iterator[str]:
    origin, arguments = get_origin(hint), get_args(hint)
    if is_dataclass(value):
        yield from out_of_range(value, name)
    elif value is None or isinstance(value, str | bool):
        return
    elif origin in (Union, UnionType):
        yield from _wrong(next(each for each in arguments if _meant(each, value)), value, name)
    elif origin is Annotated:
        inner, *bounds = arguments
        yield from _outside(bounds, value, name)
        yield from _wrong(inner, value, name)
    elif isinstance(value, tuple):
        for place, each in enumerate(value):
            yield from _wrong(arguments[0 if arguments[-1] is Ellipsis else place], each, f"{name}[{place}]")


def _meant(hint: Any, value: object) -> bool:
    """Whether this is the alternative that a number or an array belongs to."""
    while get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    return (get_origin(hint) is tuple) if isinstance(value, tuple) else hint in (int, float)


def _outside(bounds: list[Any], value: Any, name: str) -> Iterator[str]:
    for bound in bounds:
        match bound:
            case Ge(least) if not value >= least:
                yield f"{name}: must be at least {least:g}, is {value:g}"
            case Le(most) if not value <= most:
                yield f"{name}: must be at most {most:g}, is {value:g}"
            case Len(least, most) if not least <= len(value) <= (most or len(value)):
                yield f"{name}: must have {least} to {most} elements, has {len(value)}"
