"""Simpler documents of a scenario: with less in them, shorter, or with rounder numbers.

They work on plain tables, so that what is new in scenarios is simplified without a word here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from protocol.scenario.model import Time
from protocol.scenario.shape import Document, Steps

Edit = Callable[[Document], None]
Pass = Callable[[Document], list[Edit]]

_DIGITS = (1, 2, 3, 4)
_SHORTER = (0.25, 0.5, 0.75, 0.9)  # of the run
_SEEDS = range(6)
_FREE = {"name", "description", "robots", "seed"}  # tables and values that are not simply left out


def fewer_robots(document: Document) -> list[Edit]:
    """Without one robot and all that is said of it."""
    return [partial(forget, robot["id"]) for robot in document["robots"]]


def fewer_entries(document: Document) -> list[Edit]:
    """Without half of an array of tables, without a quarter, and so on down to single entries."""
    edits: list[Edit] = []
    for steps, entries in _arrays(document):
        size = len(entries)
        while size:
            edits += [partial(_cut, steps, begin, begin + size) for begin in range(0, len(entries), size)]
            size //= 2
    return edits


def fewer_keys(document: Document) -> list[Edit]:
    """Without a table, or a key of one: what holds by default."""
    tables: list[Edit] = [
        partial(_delete, (key,))
        for key, value in document.items()
        if key not in _FREE and isinstance(value, dict | list)
    ]
    inner: list[Edit] = []
    for steps, table in _tables(document):
        inner += [partial(_delete, (*steps, key)) for key in table]
    return tables + inner


def shorter(document: Document) -> list[Edit]:
    """Over sooner, down to a tick less."""
    time = document.get("time", {})
    step, limit = time.get("step", Time().step), time.get("limit", Time().limit)
    ticks = round(limit / step)
    ends = sorted({max(1, int(part * ticks)) for part in _SHORTER} | {max(1, ticks - 1)})
    return [partial(_set, ("time", "limit"), float(f"{end * step:.12g}")) for end in ends if end < ticks]


def sooner(_: Document) -> list[Edit]:
    """Everything earlier by the same factor, the end too."""
    return [partial(_hasten, factor) for factor in _SHORTER]


def plainer(document: Document) -> list[Edit]:
    """Ranges as single numbers, small seeds, ids from 1 on, a round workspace."""
    edits: list[Edit] = [
        partial(_set, steps, value[1]) for steps, value in _leaves(document) if _is_span(steps, value)
    ]
    edits += [partial(_set, ("seed",), seed) for seed in _SEEDS if seed < document["seed"]]
    if "points" in (workspace := document.get("workspace", {})):
        reach = max(math.hypot(x, y) for x, y in workspace["points"])
        edits.append(partial(_set, ("workspace",), {"radius": reach}))
    guests = [order["add"] for order in document.get("orders", []) if "add" in order]
    ids: dict[int, int] = {}
    for robot in (*document["robots"], *guests):
        ids.setdefault(robot["id"], len(ids) + 1)
    return [partial(_rename, ids), *edits] if any(i != n for i, n in ids.items()) else edits


def rounder_together(_: Document) -> list[Edit]:
    """All numbers with few digits."""
    return [partial(_round_all, digits) for digits in _DIGITS]


def rounder(document: Document) -> list[Edit]:
    """One number with fewer digits."""
    return [
        partial(_set, steps, round_)
        for steps, value in _numbers(document)
        for round_ in ([0.0] if value else []) + [_rounded(value, digits) for digits in _DIGITS]
        if _length(round_) < _length(value)
    ]


PASSES: tuple[Pass, ...] = (
    *(fewer_robots, fewer_entries, fewer_keys, shorter, sooner, shorter),
    *(plainer, rounder_together, rounder),
)


# -- places in a document


def _tables(document: Document) -> Iterator[tuple[Steps, Document]]:
    """Every table whose keys may be left out."""
    for key, value in document.items():
        if key in _FREE:
            continue
        yield from _inside((key,), value)


def _inside(steps: Steps, value: Any) -> Iterator[tuple[Steps, Document]]:
    if isinstance(value, dict):
        yield steps, value
        for key, inner in value.items():
            yield from _inside((*steps, key), inner)
    elif isinstance(value, list):
        for place, inner in enumerate(value):
            yield from _inside((*steps, place), inner)


def _arrays(document: Document) -> Iterator[tuple[Steps, list[Any]]]:
    """Every array of tables but the robots, and the groups of partitions."""
    for steps, table in [((), document), *_tables(document)]:
        for key, value in table.items():
            if key != "robots" and isinstance(value, list) and value and isinstance(value[0], dict | list):
                yield (*steps, key), value


def _leaves(document: Document, steps: Steps = ()) -> Iterator[tuple[Steps, Any]]:
    """Every value that is not a table or an array of tables."""
    for key, value in document.items():
        at = (*steps, key)
        if isinstance(value, dict):
            yield from _leaves(value, at)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for place, entry in enumerate(value):
                yield from _leaves(entry, (*at, place))
        else:
            yield at, value


def _numbers(document: Document) -> Iterator[tuple[Steps, float]]:
    for steps, value in _leaves(document):
        if isinstance(value, float):
            yield steps, value
        elif isinstance(value, list):
            yield from ((((*steps, n)), each) for n, each in enumerate(value) if isinstance(each, float))


def _is_span(steps: Steps, value: Any) -> bool:
    return steps[-1] == "delay" and isinstance(value, list)


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _length(value: float) -> int:
    """How much there is to read."""
    return len(repr(abs(value))) if value else 0


# -- edits


def _at(document: Document, steps: Steps) -> Any:
    holder: Any = document
    for step in steps:
        holder = holder[step]
    return holder


def _set(steps: Steps, value: Any, document: Document) -> None:
    for n, step in enumerate(steps[:-1]):
        if isinstance(step, str) and step not in _at(document, steps[:n]):
            _at(document, steps[:n])[step] = {}
    _at(document, steps[:-1])[steps[-1]] = value


def _delete(steps: Steps, document: Document) -> None:
    del _at(document, steps[:-1])[steps[-1]]


def _cut(steps: Steps, begin: int, end: int, document: Document) -> None:
    del _at(document, steps)[begin:end]


def _hasten(factor: float, document: Document) -> None:
    """Events and the end, at whole ticks."""
    time = document.get("time", {})
    step = time.get("step", Time().step)

    def earlier(seconds: float) -> float:
        return float(f"{math.floor(factor * seconds / step + 1e-9) * step:.12g}")

    for event in (*document.get("process", []), *document.get("orders", [])):
        event["at"] = earlier(event["at"])
    for partition in document.get("link", {}).get("partition", []):
        partition["from"] = earlier(partition["from"])
        partition["until"] = max(earlier(partition["until"]), partition["from"] + step)
    document["time"] = time | {"limit": max(earlier(time.get("limit", Time().limit)), step)}


def _round_all(digits: int, document: Document) -> None:
    for steps, value in list(_numbers(document)):
        if _length(_rounded(value, digits)) < _length(value):
            _set(steps, _rounded(value, digits), document)


def forget(robot: int, document: Document) -> None:
    """Leave out one robot and all that is said of it."""
    document["robots"] = [spec for spec in document["robots"] if spec["id"] != robot]
    if "orders" in document:
        document["orders"] = [order for order in document["orders"] if robot not in _names(order)]
    if "process" in document:
        document["process"] = [fault for fault in document["process"] if fault["robot"] != robot]
    for sensing in document.get("sensing", []):
        if "robots" in sensing:
            sensing["robots"] = [other for other in sensing["robots"] if other != robot]
    document["sensing"] = [entry for entry in document.get("sensing", [{}]) if entry.get("robots") != []]
    for partition in document.get("link", {}).get("partition", []):
        partition["groups"] = [[i for i in group if i != robot] for group in partition["groups"]]


def _names(order: Document) -> list[int | None]:
    """Ids that an order is about."""
    return [order.get("remove"), order.get("goal", {}).get("robot"), order.get("add", {}).get("id")]


def _rename(ids: dict[int, int], document: Document) -> None:
    for spec in document["robots"]:
        spec["id"] = ids[spec["id"]]
    for order in document.get("orders", []):
        for about, key in ((order, "remove"), (order.get("goal", {}), "robot"), (order.get("add", {}), "id")):
            if key in about:
                about[key] = ids[about[key]]
    for fault in document.get("process", []):
        fault["robot"] = ids[fault["robot"]]
    for sensing in document.get("sensing", []):
        if "robots" in sensing:
            sensing["robots"] = sorted(ids[robot] for robot in sensing["robots"])
    for partition in document.get("link", {}).get("partition", []):
        partition["groups"] = [sorted(ids[robot] for robot in group) for group in partition["groups"]]
