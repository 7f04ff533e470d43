"""Transitions of the kernel's objects as they run, checked by the very conjuncts that were proved.

Of two disks, a ledger and the processes of its lives give the record that the solver reasons of. After every
rule the invariant has to hold of it, and nothing may change but by a rule.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, wraps
from itertools import product
from typing import Any

import z3

from protocol.kernel import pair as pairs
from protocol.kernel.ledger import Ledger, Pair
from protocol.kernel.records import NO, Binding, DiskRecord, End
from protocol.kernel.robot import Bound, RobotLife
from tests.proof.prove import GENERAL, TEMPLATE

Record = dict[str, Any]
Conjunct = Callable[[Record, "Facts", Any, Any, Any], bool]

_OF_LEDGER = "rejoin fence settle grant acknowledge introduce ask answer part announce appear remove"
_OF_ROBOT = "hear freeze turn adopt command locate"
RULES: dict[type, list[str]] = {
    Ledger: _OF_LEDGER.split(),
    RobotLife: _OF_ROBOT.split(),
    pairs.Owner: ["propose", "on_answer"],
    pairs.Follower: ["on_proposal"],
}


class Facts(ABC):
    """What geometry says of a record: a region is named by its number, a line by two.

    Args:
        regions: that A and B hold, by number.
        firsts: first lines of bindings, by number.
        s: the record.
    """

    def __init__(self, regions: dict[str, dict[int, Any]], firsts: dict[int, Any], s: Record) -> None:
        self.regions, self._firsts, self._s = regions, firsts, s

    @abstractmethod
    def apart(self, a: int, b: int) -> bool: ...
    @abstractmethod
    def inside(self, x: str, body: Any, region: int) -> bool: ...
    @abstractmethod
    def fits(self, x: str, body: Any, line: Any) -> bool: ...
    @abstractmethod
    def disjoint(self, a: Any, b: Any) -> bool: ...

    @abstractmethod
    def shape(self, region: Any) -> Any:
        """Of a region, as a body is given."""

    def beside(self, x: str, region: int, line: Any) -> bool:
        known = self.regions[x].get(region)
        return known is None or self.fits(x, self.shape(known), line)

    def line(self, binding: int, number: int) -> Any:
        """As one of the ends keeps it, or the ledger; each line that is obeyed is kept by its end."""
        for lines in (
            self._s[f"{b}.{x}.lines"] for b in "LS" for x in "AB" if self._s[f"{b}.number"] == binding
        ):
            if number in lines:
                return lines[number]
        assert number == 0
        assert self._firsts[binding] is not None
        return self._firsts[binding]


# -- what the solver was asked, as Python

_INFIX = {
    z3.Z3_OP_AND: " and ", z3.Z3_OP_OR: " or ", z3.Z3_OP_EQ: " == ", z3.Z3_OP_LE: " <= ", z3.Z3_OP_LT: " < ",
    z3.Z3_OP_GE: " >= ", z3.Z3_OP_GT: " > ", z3.Z3_OP_ADD: " + ", z3.Z3_OP_DISTINCT: " != ",
}  # fmt: skip
_ARGUMENTS = {"any A": "ra", "any B": "rb", "any K": "k"}


def python_of(term: z3.ExprRef) -> str:
    """A term of the solver as an expression of a record `s`, of facts `g`, and of `ra`, `rb` and `k`."""
    args, kind = [python_of(each) for each in term.children()], term.decl().kind()
    if kind in _INFIX:
        return f"({_INFIX[kind].join(args)})"
    special = {
        z3.Z3_OP_NOT: "(not {0})",
        z3.Z3_OP_IMPLIES: "(not {0} or {1})",
        z3.Z3_OP_ITE: "({1} if {0} else {2})",
        z3.Z3_OP_TRUE: "True",
        z3.Z3_OP_FALSE: "False",
    }
    if kind in special:
        return special[kind].format(*args)
    if z3.is_int_value(term):
        return str(term)
    name = term.decl().name()
    if not args:
        return _ARGUMENTS.get(name, f"s[{name!r}]")
    if name[:-1] in ("inside", "beside", "fits"):
        return f"g.{name[:-1]}({name[-1]!r}, {', '.join(args)})"
    return f"g.{name}({', '.join(args)})"


@cache
def conjuncts() -> dict[str, tuple[Conjunct, list[str]]]:
    """Every conjunct to be evaluated, and the general terms that it has."""
    return {
        name: (
            eval(f"lambda s, g, ra, rb, k: {python_of(claim)}"),  # of the solver's own terms
            [_ARGUMENTS[str(term)] for term in GENERAL[name]],
        )
        for name, claim in TEMPLATE.items()
    }


def broken(s: Record, facts: Facts, ranges: Mapping[str, list[int]]) -> list[str]:
    """Conjuncts that do not hold of a record.

    Args:
        s: the record.
        facts: of it.
        ranges: numbers of the regions that A and B hold (`ra`, `rb`), and of lines (`k`).
    """
    found = []
    for name, (holds, terms) in conjuncts().items():
        each = product(*[ranges[term] if term in terms else [0] for term in ("ra", "rb", "k")])
        if not all(holds(s, facts, *values) for values in each):
            found.append(name)
    return found + [f"{b}: lines" for b in "LS" if s[f"{b}.on"] and not _numbered_alike(s, b)]


def _numbered_alike(s: Record, b: str) -> bool:
    """Whether both ends keep the same line of each number, and the owner every open proposal."""
    mine, theirs = s[f"{b}.A.lines"], s[f"{b}.B.lines"]
    alike = all(mine[number] == theirs[number] for number in mine.keys() & theirs.keys())
    open_numbers = range(s[f"{b}.A.seen"] + 1, s[f"{b}.A.number"] + 1)
    return alike and (not mine or mine.keys() >= set(open_numbers))


# -- the record of two disks

Processes = Mapping[tuple[int, int], RobotLife[Any, Any, Any]]  # by disk and life


def record(ledger: Ledger[Any, Any], processes: Processes, low: int, high: int) -> Record:
    """What the kernel keeps of two disks, but for messages: what every record of the model has."""
    found: Record = {"v": ledger.version}
    names = {"A": low, "B": high}
    for x, name in names.items():
        disk = ledger.disks[name]
        process = processes.get((name, disk.life))
        found |= {f"{x}.phase": disk.phase, f"{x}.life": disk.life, f"{x}.still": disk.still}
        found |= {f"{x}.acked": disk.held.acknowledged, f"{x}.granted": disk.held.granted, f"{x}.said": 0}
        found |= {f"{x}.taken": 0, f"{x}.offered": 0, f"{x}.obeyed": 0, f"{x}.reach": False}
        found |= {f"{x}.body": None, f"{x}.own": None}
        if process is not None:
            found |= {f"{x}.taken": process.version, f"{x}.offered": process.offered_number}
            found |= {
                f"{x}.obeyed": process.number,
                f"{x}.reach": process.part == names["B" if x == "A" else "A"],
            }
            found |= {f"{x}.body": process.body, f"{x}.own": process.own}
    bindings = bindings_of(ledger, low, high)
    for b in "LS":
        found |= _binding(b, bindings.get(b), processes)
    return found


def bindings_of(ledger: Ledger[Any, Any], low: int, high: int) -> dict[str, Binding[Any]]:
    """The bindings of two disks that are in force, by kind."""
    both = ledger.pairs[low].get(high)
    kinds = {} if both is None else {"L": both.living, "S": both.static}
    return {b: binding for b, binding in kinds.items() if binding is not None}


def _binding(b: str, binding: Binding[Any] | None, processes: Processes) -> Record:
    if binding is None:
        return {f"{b}.on": False, f"{b}.number": 0, f"{b}.told": 0}
    asked = {NO: 0, binding.low.disk: 1, binding.high.disk: 2}[binding.asked]
    found = {f"{b}.on": True, f"{b}.number": binding.number, f"{b}.told": binding.told, f"{b}.asked": asked}
    found |= {f"{b}.{f}": 0 for f in ("h", "s", "h2", "s2", "A.number")} | {f"{b}.frozen": False}
    for x, end in (("A", binding.low), ("B", binding.high)):
        process = processes.get((end.disk, end.life))
        bound = None if process is None else process.bound.get(binding.number)
        found |= {f"{b}.{x}.life": end.life, f"{b}.{x}.dead": end.dead, f"{b}.{x}.has": bound is not None}
        found |= {f"{b}.{x}.taken": 0 if process is None else process.version}
        found |= _end(f"{b}.{x}", bound)
    return found


def _end(key: str, bound: Bound[Any, Any] | None) -> Record:
    """What a process keeps of its end."""
    lines = None if bound is None else bound.lines
    found: Record = {f"{key}.state": 0, f"{key}.static": False, f"{key}.half": None}
    found |= {f"{key}.seen": 0, f"{key}.held": 0, f"{key}.lines": {}}
    if bound is not None:
        found |= {f"{key}.state": bound.state, f"{key}.static": bound.static, f"{key}.half": bound.half}
    if lines is not None:
        known = {lines.held_number: lines.held}
        found |= {f"{key}.seen": lines.seen, f"{key}.held": lines.held_number, f"{key}.lines": known}
        if isinstance(lines, pairs.Owner):
            known.update(lines.open)
            found |= {f"{key}.number": lines.number}
    return found


def ranges_of(ledger: Ledger[Any, Any], s: Record, low: int, high: int) -> dict[str, list[int]]:
    """Numbers of the regions that two disks hold, and of the lines of their bindings."""
    held = {
        key: [number for number, _ in ledger.disks[name].held.regions]
        for key, name in (("ra", low), ("rb", high))
    }
    lines = {0} | {k for b in "LS" if s[f"{b}.on"] for x in "AB" for k in s[f"{b}.{x}.lines"]}
    return {**held, "k": sorted(lines)}


# -- rules as they are taken


class Watch:
    """Which rules are taken while it looks on, and what is wrong with them.

    Args:
        check: what is wrong after a rule of a ledger or robot; looks at what it likes.

    Attributes:
        taken: how often each rule was.
        wrong: what was, in words.
        processes: all robots that were begun, by disk and life.
        ledgers: all ledgers, the newest last.
    """

    def __init__(self, check: Callable[[Watch, str], list[str]]) -> None:
        self.taken: Counter[str] = Counter()
        self.wrong: list[str] = []
        self.processes: dict[tuple[int, int], RobotLife[Any, Any, Any]] = {}
        self.ledgers: list[Ledger[Any, Any]] = []
        self._check, self._depth = check, 0

    def rule(self, name: str, does: Callable[..., Any]) -> Callable[..., Any]:
        """A rule that is looked at."""

        @wraps(does)
        def taken(*args: Any, **kwargs: Any) -> Any:
            self._depth += 1
            try:
                result = does(*args, **kwargs)
            finally:
                self._depth -= 1
            if not self._depth:
                self.taken[name] += 1
                self.wrong += [f"{name}: {each}" for each in self._check(self, name)]
            return result

        return taken

    def begins(self, does: Callable[..., None]) -> Callable[..., None]:
        """A ledger or a robot begins."""

        @wraps(does)
        def begun(made: Any, *args: Any, **kwargs: Any) -> None:
            self._depth += 1
            try:
                does(made, *args, **kwargs)
            finally:
                self._depth -= 1
            if isinstance(made, Ledger):
                self.ledgers.append(made)
            elif isinstance(made, RobotLife):
                self.processes[made.name, made.life] = made

        return begun

    def writes(self, made: Any, field: str, value: Any) -> None:
        """A field of one of the kernel's objects is written, which only rules do."""
        if not self._depth:
            self.wrong.append(f"{type(made).__name__}.{field} is written by no rule")
        object.__setattr__(made, field, value)


_OF_LEDGERS = (Ledger, Pair, DiskRecord, Binding, End)
_KEPT = (*_OF_LEDGERS, RobotLife, Bound, pairs.Owner, pairs.Follower)


@contextmanager
def watched(watch: Watch) -> Iterator[Watch]:
    """Look at every rule of the kernel that is taken meanwhile. The kernel must not be compiled."""
    before: list[tuple[Any, str, Any]] = []

    def put(kind: Any, name: str, value: Any) -> None:
        before.append((kind, name, kind.__dict__.get(name)))
        setattr(kind, name, value)

    try:
        for kind, names in RULES.items():
            for name in names:
                put(kind, name, watch.rule(f"{kind.__name__}.{name}", getattr(kind, name)))
        for each in _KEPT:
            put(each, "__init__", watch.begins(each.__init__))
            put(each, "__setattr__", _setter(watch))
        yield watch
    finally:
        for kind, name, was in reversed(before):
            if was is None:
                delattr(kind, name)
            else:
                setattr(kind, name, was)


def _setter(watch: Watch) -> Callable[[Any, str, Any], None]:
    def sets(made: Any, field: str, value: Any) -> None:
        watch.writes(made, field, value)

    return sets
