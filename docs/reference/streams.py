"""Writes `docs/streams.md` from the code's declarations: `python -m docs.reference.streams`."""

from __future__ import annotations

import ast
import inspect
import re
import tokenize
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import msgspec

from protocol import joining, keys, messages, operations
from protocol.keys import STREAMS, Stream

PAGE = Path(__file__).parents[2] / "docs" / "streams.md"

SUBSCRIBER = """\
import sys, msgpack, zenoh

endpoint, run = sys.argv[1:]  # such as tcp/127.0.0.1:7447 and the name of the run
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", f'["{endpoint}"]')
with zenoh.open(config) as session, session.declare_subscriber(f"disknav/{run}/**") as subscriber:
    for sample in subscriber:
        kind, *fields = msgpack.unpackb(sample.payload.to_bytes())
        print(sample.key_expr, kind, fields, flush=True)
"""

_HEAD = """\
# Streams

What crosses the network, for programs that share no code with this project. Generated from the
declarations in `protocol/` by `python -m docs.reference.streams`; do not edit.

Every published payload is one [msgpack](https://msgpack.org) array: first a text that names type and protocol
version, such as `"state/{version}"`, then the fields in the order of the tables below. A reader should
ignore what has another version, and may ignore fields after those it knows. Ticks and Commands end with the
last field that says something: what is left out is nil, false, 0 or an empty array, whichever it can be.

A complete subscriber, with nothing but `pip install eclipse-zenoh msgpack`:

```python
{subscriber}```

## Keys

```
{grammar}
```
"""

_REFUSED = """\
A malformed request is answered with `{"reply": "refused", "text": why}` in the form that it came in; a
malformed operation as one that is not accepted.
"""

_RECORDED = """\
## In a recording

`disknav run --record` writes the messages that the table marks to an MCAP file: one channel a key, with the
time of the tick as log time. There a message is a JSON object under the field names above, without its
type; `[x, y]` is `{"x": .., "y": ..}`, and a field that is nil is left out. Every channel has its JSON
schema. Topics that begin with `/` draw the run, for [Foxglove](guides/foxglove.md), and say nothing that
the others do not. The metadata records `scenario` and `result` hold JSON objects.
"""

_UNIT = re.compile(r"(m/s|m\^2|m|s|rad)[,;] (.*)")
_WORDS: dict[type, str] = {
    msgspec.inspect.BoolType: "true or false",
    msgspec.inspect.IntType: "integer",
    msgspec.inspect.FloatType: "number",
    msgspec.inspect.StrType: "text",
    msgspec.inspect.BytesType: "binary",
}
_INNER = (
    messages.Proposal,
    messages.Answer,
    messages.FirstLine,
    messages.ListedBinding,
    messages.Grants,
    messages.Sense,
    messages.BaseMotion,
    messages.Roster,
    messages.Member,
    messages.PlacedObstacle,
    messages.PartPlace,
    messages.Report,
    messages.Claim,
    messages.Handling,
    messages.Standing,
)


def page() -> str:
    """The whole page."""
    parts = [
        _HEAD.format(version=messages.VERSION, subscriber=SUBSCRIBER, grammar=_grammar()),
        _conventions(),
        _overview(),
        *(_section(f"`{stream.name}`", stream.message) for stream in STREAMS.values()),
        "## Inside them\n\nArrays without a type in front.\n",
        *(_section(inner.__name__, inner, level=3) for inner in _INNER),
        _requests(),
        _RECORDED,
    ]
    return "\n".join(parts)


def _grammar() -> str:
    """The grammar as the module of the keys states it."""
    text = inspect.getdoc(keys) or ""
    block = text.split("Grammar::\n\n")[1].split("\n\n")[0]
    return inspect.cleandoc(block)


def _conventions() -> str:
    notes = (inspect.getdoc(messages) or "").split("\n\n")[1].split("\n")[:2]
    alive = (
        "The `alive` keys are liveliness tokens: a robot's is there from the moment it has joined until its\n"
        "process ends or hangs; subscribe to `disknav/<run>/**` liveliness, with history, to see all."
    )
    admin = (
        "A router started with `--admin`, or a `zenohd`, lists the declarations of these keys in its admin\n"
        "space: `@/*/router/subscriber/disknav/<run>/**`; likewise `publisher`, `queryable` and `token`.\n"
        "`@/*/router` lists the connected sessions. Asking for `@/**` at once can block a router for good."
    )
    return "\n".join([*notes, "", alive, "", admin, ""])


def _overview() -> str:
    rows = [
        "| key | published by | how often | bytes at most | when the network is full | recorded |",
        "|---|---|---|---|---|---|",
    ]
    for stream in STREAMS.values():
        full = "publisher waits" if stream.reliable else "sample is dropped"
        recorded = "yes" if stream.recorded else "as metadata" if stream.name == "result" else "no"
        cells = (f"`{_key(stream)}`", stream.publisher, stream.rate, f"{stream.limit:,}", full, recorded)
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join([*rows, ""])


def _key(stream: Stream) -> str:
    owner = "robot/<id>" if stream.name in keys.ROBOT_STREAMS else "world"
    return f"disknav/<run>/{owner}/{stream.name}"


def _section(title: str, struct: type[msgspec.Struct], level: int = 2) -> str:
    tagged = issubclass(struct, messages.Message)
    rows = ["| place | field | type | unit | meaning |", "|---|---|---|---|---|"]
    if tagged:
        rows.append(f'| 0 | | text | | `"{struct.__struct_config__.tag}"` |')
    described = msgspec.inspect.type_info(struct)
    assert isinstance(described, msgspec.inspect.StructType)
    for place, field in enumerate(described.fields, start=int(tagged)):
        unit, meaning = _words(struct, field.name)
        rows.append(f"| {place} | {field.name} | {_type(field.type)} | {unit} | {meaning} |")
    return "\n".join([f"{'#' * level} {title}", "", inspect.getdoc(struct) or "", "", *rows, ""])


def _type(described: Any) -> str:
    match described:
        case msgspec.inspect.Metadata():
            names = (described.extra or {}).get("names")
            return f"[{', '.join(names)}]" if names else _type(described.type)
        case msgspec.inspect.UnionType():
            present = (each for each in described.types if not isinstance(each, msgspec.inspect.NoneType))
            return f"{' or '.join(map(_type, present))} or nil"
        case msgspec.inspect.VarTupleType():
            return f"array of {_type(described.item_type)}"
        case msgspec.inspect.DictType():
            return f"map from {_type(described.key_type)} to {_type(described.value_type)}"
    return _plain(described)


def _plain(described: Any) -> str:
    if isinstance(described, msgspec.inspect.TupleType):
        return "[x, y]"
    if isinstance(described, msgspec.inspect.StructType):
        return f"[{described.cls.__name__}](#{described.cls.__name__.lower()})"
    if isinstance(described, msgspec.inspect.LiteralType):
        return " or ".join(f'"{value}"' for value in described.values)
    return _WORDS[type(described)]


def _words(struct: type[msgspec.Struct], field: str) -> tuple[str, str]:
    """Unit and meaning of a field, from the comment beside its declaration.

    Raises:
        KeyError: a field has no comment.
    """
    text = _comments()[struct.__name__, field].replace("None", "nil").replace("|", "\\|")
    found = _UNIT.fullmatch(text)
    return (found[1].replace("^2", "²"), found[2]) if found else ("", text)


@cache
def _comments() -> dict[tuple[str, str], str]:
    """Comments beside the fields of all messages, by class and field."""
    source = inspect.getsource(messages)
    beside = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokenize.generate_tokens(StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    found = {}
    for declared in ast.parse(source).body:
        if isinstance(declared, ast.ClassDef):
            for field in declared.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                    found[declared.name, field.target.id] = beside[field.lineno]
    return found


def _requests() -> str:
    """What can be asked, in the words of the modules that answer."""
    parts = ["## Requests", "", _REFUSED]
    asked = {
        "robot/<id>/join": joining,
        "world/operation": operations,
    }
    for name, module in asked.items():
        parts += [f"### `disknav/<run>/{name}`", "", inspect.getdoc(module) or "", ""]
    return "\n".join(parts)


if __name__ == "__main__":
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page())
