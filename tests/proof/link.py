"""Transitions of the kernel's objects as they run, checked by the very conjuncts that were proved.

Of two disks, a ledger and the processes of its lives give the record that the solver reasons of. After every
rule the invariant has to hold of it, and nothing may change but by a rule.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import cache, wraps
from itertools import product
from typing import Any
from unittest.mock import patch

import z3

from protocol.kernel.ledger import Ledger, Pair
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.records import Binding, DiskRecord, End
from protocol.kernel.robot import Bound, RobotLife
from tests.proof.model import BOOL, FIELDS, INT, bindings_of, end_fields, general_in, ledger_fields
from tests.proof.prove import TEMPLATE

Record = dict[str, Any]
Conjunct = Callable[[Record, "Facts", Any, Any, Any], bool]

_OF_LEDGER = "rejoin fence settle grant acknowledge introduce ask answer part announce appear remove"
_OF_ROBOT = "hear freeze turn adopt command locate"
RULES: dict[type, list[str]] = {
    Ledger: _OF_LEDGER.split(),
    RobotLife: _OF_ROBOT.split(),
    Owner: ["propose", "on_answer"],
    Follower: ["on_proposal"],
}


class Facts(ABC):
    """What geometry says of a record: a region is named by its number, a line by two.

    Args:
        ledger: it is of.
        low: disk.
        high: disk.
        s: the record.

    Attributes:
        regions: that A and B hold, by number.
    """

    def __init__(self, ledger: Ledger[Any, Any], low: int, high: int, s: Record) -> None:
        self.regions = {x: dict(ledger.disks[name].held.regions) for x, name in (("A", low), ("B", high))}
        self._firsts = {each.number: each.first for each in bindings_of(ledger, low, high).values()}
        self._s = s

    @abstractmethod
    def inside(self, x: str, body: Any, region: int) -> bool: ...
    @abstractmethod
    def fits(self, x: str, body: Any, line: Any) -> bool: ...
    @abstractmethod
    def disjoint(self, a: Any, b: Any) -> bool: ...

    def clear(self, a: Any, b: Any) -> bool:
        """Of two regions."""
        return self.disjoint(a, b)

    def shape(self, region: Any) -> Any:
        """Of a region, as a body is given."""
        return region

    def apart(self, a: int, b: int) -> bool:
        one, other = self.regions["A"].get(a), self.regions["B"].get(b)
        return one is None or other is None or self.clear(one, other)

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
_SPECIAL = {
    z3.Z3_OP_NOT: "(not {0})", z3.Z3_OP_IMPLIES: "(not {0} or {1})", z3.Z3_OP_ITE: "({1} if {0} else {2})",
    z3.Z3_OP_TRUE: "True", z3.Z3_OP_FALSE: "False",
}  # fmt: skip
_ARGUMENTS = {"any A": "ra", "any B": "rb", "any K": "k"}


def python_of(term: z3.ExprRef) -> str:
    """A term of the solver as an expression of a record `s`, of facts `g`, and of `ra`, `rb` and `k`."""
    args, kind = [python_of(each) for each in term.children()], term.decl().kind()
    if kind in _INFIX:
        return f"({_INFIX[kind].join(args)})"
    if kind in _SPECIAL:
        return _SPECIAL[kind].format(*args)
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
            [_ARGUMENTS[str(term)] for term in general_in(claim)],
        )
        for name, claim in TEMPLATE.items()
    }


def broken(s: Record, facts: Facts) -> list[str]:
    """Conjuncts that do not hold of a record: any region of A (`ra`), any of B (`rb`), any line (`k`)."""
    lines = {0} | {k for b in "LS" if s[f"{b}.on"] for x in "AB" for k in s[f"{b}.{x}.lines"]}
    ranges = {"ra": facts.regions["A"], "rb": facts.regions["B"], "k": lines}
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

_NOTHING: Record = {
    name: 0 if sort == INT else False if sort == BOOL else None for name, sort in FIELDS.items()
}
Processes = Mapping[tuple[int, int], RobotLife[Any, Any, Any]]  # by disk and life


def record(ledger: Ledger[Any, Any], processes: Processes, low: int, high: int) -> Record:
    """What the kernel keeps of two disks, but for messages: what every record of the model has."""
    found = _NOTHING | {"id.A": low, "id.B": high} | ledger_fields(ledger, low, high)
    for x, name, other in (("A", low, high), ("B", high, low)):
        process = processes.get((name, ledger.disks[name].life))
        if process is not None:
            found |= {f"{x}.taken": process.version, f"{x}.offered": process.offered_number}
            found |= {f"{x}.obeyed": process.number, f"{x}.reach": process.part == other}
            found |= {f"{x}.body": process.body, f"{x}.own": process.own}
    for b, binding in bindings_of(ledger, low, high).items():
        for x, end in (("A", binding.low), ("B", binding.high)):
            process = processes.get((end.disk, end.life))
            bound = None if process is None else process.bound.get(binding.number)
            found[f"{b}.{x}.taken"] = 0 if process is None else process.version
            found |= {} if bound is None else end_fields(b, x, bound)
            found[f"{b}.{x}.lines"] = _lines(bound)
    return found


def _lines(bound: Bound[Any, Any] | None) -> dict[int, Any]:
    """The lines that an end keeps, by number."""
    lines = None if bound is None else bound.lines
    if lines is None:
        return {}
    known = {lines.held_number: lines.held}
    return known | dict(lines.open) if isinstance(lines, Owner) else known


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

    def call(self, kind: type, name: str) -> Callable[..., Any]:
        """A rule that is looked at, or the beginning of a ledger, a robot or what they keep."""
        does = getattr(kind, name)

        @wraps(does)
        def done(made: Any, *args: Any, **kwargs: Any) -> Any:
            self._depth += 1
            try:
                result = does(made, *args, **kwargs)
            finally:
                self._depth -= 1
            if name == "__init__":
                self._begun(made)
            elif not self._depth:
                rule = f"{kind.__name__}.{name}"
                self.taken[rule] += 1
                self.wrong += [f"{rule}: {each}" for each in self._check(self, rule)]
            return result

        return done

    def _begun(self, made: Any) -> None:
        if isinstance(made, Ledger):
            self.ledgers.append(made)
        elif isinstance(made, RobotLife):
            self.processes[made.name, made.life] = made

    def writes(self, made: Any, field: str, value: Any) -> None:
        """A field of one of the kernel's objects is written, which only rules do."""
        if not self._depth:
            self.wrong.append(f"{type(made).__name__}.{field} is written by no rule")
        object.__setattr__(made, field, value)


_KEPT = (Ledger, Pair, DiskRecord, Binding, End, RobotLife, Bound, Owner, Follower)


@contextmanager
def watched(watch: Watch) -> Iterator[Watch]:
    """Look at every rule of the kernel that is taken meanwhile. The kernel must not be compiled."""

    def sets(made: Any, field: str, value: Any) -> None:
        watch.writes(made, field, value)

    with ExitStack() as stack:
        for kind in _KEPT:
            for name in ("__init__", *RULES.get(kind, ())):
                stack.enter_context(patch.object(kind, name, watch.call(kind, name)))
            stack.enter_context(patch.object(kind, "__setattr__", sets))
        yield watch
