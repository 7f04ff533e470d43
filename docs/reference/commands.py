"""The page of commands, from the command line's own declarations."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import typer

from deploy.cli.application import GROUPS

_HEAD = """\
# Commands

From the command line's own declarations; `disknav COMMAND --help` says the same. An option that cannot
apply is refused. `--json` with nothing or `-` after it prints to standard output."""

_PLAIN = {int: "N", float: "NUMBER", str: "TEXT", Path: "FILE"}


def page() -> str:
    """As Markdown."""
    lines = [_HEAD]
    for group, commands in GROUPS.items():
        lines += ["", f"## {group}"]
        for command in commands:
            lines += _sections(command)
    return "\n".join(lines) + "\n"


def _sections(command: Callable[..., None] | typer.Typer) -> Iterator[str]:
    if not isinstance(command, typer.Typer):
        yield from _section(f"disknav {command.__name__}", command)
        return
    for inner in command.registered_commands:
        if inner.callback is not None and not inner.hidden:
            word = inner.name or inner.callback.__name__
            yield from _section(f"disknav {command.info.name} {word}", inner.callback)


def _section(name: str, call: Callable[..., None]) -> Iterator[str]:
    yield from ("", f"### `{name}`", "", _text(inspect.getdoc(call) or ""))
    parameters = inspect.signature(call).parameters
    if parameters:
        yield from ("", "| | default | |", "|---|---|---|")
    hints = get_type_hints(call, include_extras=True)
    for parameter in parameters.values():
        yield _row(parameter, hints[parameter.name])


def _row(parameter: inspect.Parameter, hint: Any) -> str:
    kind, info = get_args(hint)[:2]
    shown = parameter.name.upper()
    if isinstance(info, typer.models.ArgumentInfo):
        names = f"`{info.metavar or shown}`"
    else:
        first = (info.default,) if isinstance(info.default, str) else ()  # where Annotated puts it
        declared = (*first, *(info.param_decls or ())) or (f"--{parameter.name.replace('_', '-')}",)
        takes = "" if kind is bool else f" {info.metavar or _type(kind)}"
        names = ", ".join(f"`{name}{takes if name.startswith('--') else ''}`" for name in declared)
    default = parameter.default
    given = "" if default in (None, False, "", parameter.empty) else f"`{default}`"
    return f"| {names} | {given} | {_cell(info.help or '')}{_choices(kind)} |"


def _type(kind: Any) -> str:
    if get_origin(kind) is Literal:
        return "CHOICE"
    parts = [part for part in get_args(kind) if part is not NoneType]
    return _type(parts[0]) if parts else _PLAIN.get(kind, "VALUE")


def _choices(kind: Any) -> str:
    if get_origin(kind) is Literal:
        return f" One of {', '.join(f'`{choice}`' for choice in get_args(kind))}."
    return "".join(_choices(part) for part in get_args(kind))


def _text(help_: str) -> str:
    text = re.sub(r"\[/?b\]", "**", help_)
    return re.sub(r"^Examples?: (.*?)(?=\n\n|\Z)", _example, text, flags=re.DOTALL | re.MULTILINE)


def _example(found: re.Match[str]) -> str:
    lines = re.split(r"; (?:in another terminal: )?(?=disknav)", " ".join(found[1].split()))
    return "\n".join(["```", *lines, "```"])


def _cell(text: str) -> str:
    return re.sub(r"\[/?b\]", "**", text).replace("|", "\\|")
