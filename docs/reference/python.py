"""The page of `import disknav`, from its signatures and docstrings."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import disknav


def page() -> str:
    """As Markdown."""
    lines = ["# `import disknav`", "", "From signatures and docstrings. [Examples](../guides/python.md)."]
    for name in disknav.__all__:
        obstacle = getattr(disknav, name)
        own = obstacle.__module__.startswith("disknav")
        lines += ["", f"## `{name}{_signature(obstacle) if own else ''}`", "", _text(obstacle)]
        if inspect.isclass(obstacle) and own:
            lines += _members(obstacle)
    return "\n".join(lines) + "\n"


def _members(kind: type) -> Iterator[str]:
    for name, member in vars(kind).items():
        if name.startswith("_") or not inspect.getdoc(member):
            continue
        if isinstance(member, property):
            yield from ("", f"### `.{name}`", "", _text(member))
        elif callable(member) or isinstance(member, classmethod):
            yield from ("", f"### `.{name}{_signature(member)}`", "", _text(member))


def _signature(obstacle: Any) -> str:
    try:
        found = inspect.signature(getattr(obstacle, "__func__", obstacle))
    except (TypeError, ValueError):
        return ""
    parameters = [each for each in found.parameters.values() if each.name not in ("self", "cls")]
    return f"({', '.join(str(each).split(':')[0] + _default(each) for each in parameters)})"


def _default(parameter: inspect.Parameter) -> str:
    return "" if parameter.default is parameter.empty else f"={parameter.default!r}"


def _text(obstacle: Any) -> str:
    """A docstring, its sections of arguments and errors as lists."""
    text = inspect.getdoc(obstacle) or ""
    text = re.sub(r"^(Args|Attributes|Returns|Raises):$", r"**\1**\n", text, flags=re.MULTILINE)
    text = re.sub(r"^    (\w[\w, ]*): ", r"- `\1`: ", text, flags=re.MULTILINE)
    return re.sub(r"^ {4,8}(?=\S)", "  ", text, flags=re.MULTILINE)
