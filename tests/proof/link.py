"""Runtime verification of the kernel's objects by the proved invariant.

A ledger and the processes of its lives give the state of two disks in the model. After every rule it has to
satisfy the invariant.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from itertools import chain
from typing import Any

import z3

from protocol.geometry import Disk, Shape
from protocol.kernel.ledger import Ledger
from protocol.kernel.records import Held
from protocol.kernel.robot import OwnEnd, RobotLife
from protocol.line import ROUNDING, Line
from protocol.region import Region, RegionGeometry, distance
from tests.proof.model import S, bindings_of, end_fields, ledger_fields, process_fields, variables_in
from tests.proof.prove import INVARIANT

Processes = Mapping[tuple[int, int], RobotLife[Any, Any, Any]]  # by disk and life

# -- the solver's terms, as Python

_INFIX = {"=": "==", "distinct": "!="} | {name: name for name in ["and", "or", "<=", "<", ">=", ">", "+"]}
_SPECIAL = {
    "not": "(not {0})", "=>": "(not {0} or {1})", "if": "({1} if {0} else {2})", "true": "True",
    "false": "False",
}  # fmt: skip


def python_of(term: z3.ExprRef) -> str:
    """A term of the solver as an expression of facts `g`, their record `s`, and variables."""
    args, name = [python_of(each) for each in term.children()], term.decl().name()
    if name in _INFIX:
        return f"({f' {_INFIX[name]} '.join(args)})"
    if name in _SPECIAL:
        return _SPECIAL[name].format(*args)
    if z3.is_int_value(term) or name.startswith("any_"):
        return str(term)
    if not args:
        return f"s[{name!r}]"
    if name[:-1] in ("inside", "beside", "fits"):
        return f"g.{name[:-1]}({name[-1]!r}, {', '.join(args)})"
    return f"g.{name}({', '.join(args)})"


@cache
def conjuncts() -> dict[str, Callable[[Facts, Record], bool]]:
    """Each conjunct as a function, for all values of its variables."""
    found = {}
    for name, claim in INVARIANT.items():
        each = [f" for {term} in g.any[{str(term)!r}]" for term in variables_in(claim)] or [" for _ in [0]"]
        found[name] = eval(f"lambda g, s: all({python_of(claim)}{''.join(each)})")  # the solver's own terms
    return found


# -- two disks

Record = dict[str, Any]
_NOTHING: Record = {
    name: 0 if z3.is_int(term) else False if z3.is_bool(term) else None for name, term in S.items()
}


def record(ledger: Ledger[Any, Any], processes: Processes, low: int, high: int) -> Record:
    """The state of two disks in the kernel, without messages."""
    found = _NOTHING | {"id.A": low, "id.B": high} | ledger_fields(ledger, low, high)
    for x, name, other in (("A", low, high), ("B", high, low)):
        process = processes.get((name, ledger.disks[name].life))
        if process is not None:
            found |= process_fields(x, process) | {f"{x}.reach": process.part == other}
    for b, binding in bindings_of(ledger, low, high).items():
        for x, end in (("A", binding.low), ("B", binding.high)):
            process = processes.get((end.disk, end.life))
            kept = None if process is None else process.ends.get(binding.number)
            found[f"{b}.{x}.taken"] = 0 if process is None else process.version
            found |= {} if kept is None else end_fields(b, x, kept)
            found[f"{b}.{x}.lines"] = _lines(kept)
    return found


def _lines(end: OwnEnd[Any, Any] | None) -> dict[int, Any]:
    """The lines of an end, by number."""
    lines = None if end is None else end.lines
    return {} if lines is None else {lines.held_number: lines.held, **dict(getattr(lines, "open", ()))}


class Facts:
    """Two disks, and the functions of the model for them: a region is its number, a line a pair of numbers.

    Args:
        ledger: their ledger.
        processes: of its lives.
        low: disk, A.
        high: disk, B.

    Attributes:
        s: their record, without messages; a body is a disk, or an obstacle's shape.
        any: values of each variable, by its name: regions held, by number, and numbers of lines.
    """

    def __init__(self, ledger: Ledger[Region, Line], processes: Processes, low: int, high: int) -> None:
        self.s = s = record(ledger, processes, low, high)
        bindings = bindings_of(ledger, low, high)
        self._kept = {each.number: [s[f"{b}.{x}.lines"] for x in "AB"] for b, each in bindings.items()}
        self._firsts = {each.number: each.first for each in bindings.values()}
        held = {f"any_{x}": dict(ledger.disks[name].held.regions) for x, name in (("A", low), ("B", high))}
        self.any: dict[str, Any] = held | {"any_K": {0}.union(*chain(*self._kept.values()))}

    def broken(self) -> list[str]:
        """Conjuncts that do not hold, and bindings whose ends differ in a line of one number."""
        found = [name for name, holds in conjuncts().items() if not holds(self, self.s)]
        return found + [f"{b}: lines" for b in "LS" if self.s[f"{b}.on"] and not self._numbered_alike(b)]

    def _numbered_alike(self, b: str) -> bool:
        """Whether both ends keep the same line of each number, and the owner every open proposal."""
        mine, theirs = self._kept[self.s[f"{b}.number"]]
        alike = all(mine[number] == theirs[number] for number in mine.keys() & theirs.keys())
        open_numbers = range(self.s[f"{b}.A.seen"] + 1, self.s[f"{b}.A.number"] + 1)
        return alike and (not mine or mine.keys() >= set(open_numbers))

    # -- the functions of the model

    def inside(self, x: str, body: Shape, region: int) -> bool:
        known = self.any[f"any_{x}"].get(region)
        if known is None or known.is_everywhere or not isinstance(body, Disk):
            return known is not None
        around = known.shape.around
        return math.hypot(around.x - body.x, around.y - body.y) + body.radius <= around.radius + ROUNDING

    def fits(self, x: str, body: Shape, line: Line) -> bool:
        side = 1.0 if x == "A" else -1.0
        return body.support(side * line.nx, side * line.ny) <= side * line.offset + ROUNDING

    def disjoint(self, a: Shape, b: Shape) -> bool:
        return distance(a, b) >= -ROUNDING

    def apart(self, a: int, b: int) -> bool:
        one, other = self.any["any_A"].get(a), self.any["any_B"].get(b)
        return one is None or other is None or RegionGeometry().clear(Held(a, one), other)

    def beside(self, x: str, region: int, line: Line) -> bool:
        known = self.any[f"any_{x}"].get(region)
        return known is None or self.fits(x, known.shape, line)

    def line(self, binding: int, number: int) -> Line:
        """The line at one of the ends, or the first line in the ledger."""
        known = [lines[number] for lines in self._kept[binding] if number in lines]
        assert known or number == 0
        return known[0] if known else self._firsts[binding]
