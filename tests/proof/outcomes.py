"""One way through a rule of the kernel: the state after it, and what geometry answered."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import z3

from tests.proof import symbolic
from tests.proof.model import (
    APART,
    BESIDE,
    CODE,
    FITS,
    HALF,
    INSIDE,
    LINE,
    LINE_OF,
    LINES,
    OTHER,
    Terms,
    fresh,
    obeys,
    smaller,
)

NAMES = {CODE[x]: x for x in "AB"}
S = fresh("")
NEXT = S["v"] + 1
PART, EPOCH = z3.Int("part"), z3.Int("epoch")
ANY_LINE = z3.Const("any line", LINE)
HALF_PLANE, PROPOSED = z3.Const("half", LINE), z3.Int("proposed")
OBEYED = {b: z3.Int(f"{b}.any line") for b in "LS"}  # number of any line of a binding
SAID = {x: z3.Int(f"{x}.also said") for x in "AB"}  # the region of any acknowledgement under way
HELD = {x: z3.Int(f"{x}.any held") for x in "AB"}  # number of any region


Facts = Callable[[Terms], Iterable[Any]]


class Outcome:
    """One way through one rule.

    Attributes:
        after: the state.
        facts: further facts, given the terms.
        terms: that occur in this way.
        claims: to be proved besides, by name.
    """

    def __init__(self, geometry: Geometry | None = None) -> None:
        self.after: dict[str, Any] = dict(S)
        self.facts: list[Facts] = [] if geometry is None else geometry.facts
        self.terms = Terms() if geometry is None else geometry.terms
        self.claims: dict[str, Any] = {}

    def given(self, *facts: Any) -> None:
        """Further facts, that do not depend on the terms."""
        self.facts.append(lambda _: list(facts))

    def covers_less(self, x: str, small: Any, large: Any) -> None:
        """One body of X covers no more than another."""
        self.terms.bodies[x].append(small)
        self.terms.bodies[x].append(large)
        self.facts.append(lambda t: smaller(x, small, large, t))

    def stands_at(self, x: str, body: Any, region: Any) -> None:
        """The body of X is within a region, and no part is reached for."""
        self.after[f"{x}.body"] = self.after[f"{x}.own"] = body
        self.after[f"{x}.reach"] = False
        self.terms.bodies[x].append(body)
        self.terms.regions[x].append(region)

    def begins(self, x: str) -> None:
        """A process that has heard nothing."""
        for kept in ("taken", "offered", "obeyed"):
            self.after[f"{x}.{kept}"] = 0


@dataclass
class Case:
    """One rule.

    Attributes:
        rule: its name.
        run: it.
        given: what the caller sees to.
        starts: whether there is no state before it.
    """

    rule: str
    run: Callable[[], Outcome]
    given: list[Any] = field(default_factory=list)
    starts: bool = False


@dataclass
class _Noted:
    """What geometry was told of a disk; its regions, unless that was before the rule."""

    phase: Any
    acknowledged: Any
    granted: Any
    regions: list[Any] | None = None


class Geometry:
    """Answers that the solver chooses; a yes says something of every region held."""

    def __init__(self) -> None:
        self.facts: list[Facts] = []
        self.terms = Terms()
        self._count = 0
        self.noted = {x: _Noted(*[S[f"{x}.{f}"] for f in ("phase", "acked", "granted")]) for x in "AB"}
        self.disks: dict[Any, Any] = {}

    def _answer(self, says: Facts) -> z3.BoolRef:
        assert symbolic.is_unchanged(), "geometry is asked after a change"
        self._count += 1
        answer = z3.Bool(f"answer{self._count}")
        self.facts.append(lambda terms: [z3.Implies(answer, each) for each in says(terms)])
        return answer

    def _answer_of(self, held: Any, says: Callable[[Any], Any]) -> z3.BoolRef:
        """A yes says this of every region that a disk holds; of a third disk nothing is asked."""
        holds = _held_by(held)
        return self._answer(lambda t: [z3.Implies(holds(r), says(r)) for r in t.regions.get(held.disk, ())])

    # of the ledger

    def note(self, disk: Any) -> None:
        held = disk.held
        self.noted[NAMES[disk.name]] = _Noted(disk.phase, held.acknowledged, held.granted, [*held.regions])

    def around(self, disk: Any, region: Any) -> list[int]:
        """A disk that is not named holds nothing that meets the region, or what the disk holds."""
        other = self.disks[CODE[OTHER[NAMES[disk.name]]]]
        far = z3.And(self.clear(other.held, region), self.apart(other.held, disk.held))
        return [name for name in self.disks if name != other.name or not far]

    def apart(self, one: Any, other: Any) -> z3.BoolRef:
        if one is other:
            return False
        if not (one.disk and other.disk):
            return self._answer(lambda _: [])
        holds = {each.disk: _held_by(each) for each in (one, other)}
        return self._answer(
            lambda t: [
                z3.Implies(z3.And(holds["A"](ra), holds["B"](rb)), APART(ra, rb))
                for ra, rb in product(t.regions["A"], t.regions["B"])
            ]
        )

    def clear(self, held: Any, region: Any) -> z3.BoolRef:
        return self._answer_of(held, lambda r: apart(held.disk, r, region))

    def beside(self, held: Any, line: Any, low: bool) -> z3.BoolRef:
        assert low == (held.disk == "A")
        return self._answer_of(held, lambda r: BESIDE[held.disk](r, line))

    def within(self, place: Any, held: Any) -> z3.BoolRef:
        x, holds = held.disk, _held_by(held)
        around = z3.Int(f"around{x}")
        self.terms.regions[x].append(around)
        return self._answer(
            lambda t: [
                holds(around),
                *[z3.Implies(BESIDE[x](around, line), BESIDE[x](place, line)) for line in t.lines],
                *[z3.Implies(apart(x, around, r), apart(x, place, r)) for r in t.regions[OTHER[x]]],
            ]
        )

    # of a robot

    def inside(self, body: Any, region: Any) -> z3.BoolRef:
        return INSIDE[self.x](body, region)

    def fits(self, body: Any, line: Any, low: bool) -> z3.BoolRef:
        assert low == (self.x == "A")
        return FITS[self.x](body, line)

    def behind(self, place: Any, line: Any, low: bool) -> z3.BoolRef:
        assert low == (self.x == "B")
        return BESIDE[OTHER[self.x]](place, line)

    def keeps(self, body: Any, bound: Any) -> z3.BoolRef:
        x, b = self.x, bound.of
        if not b:
            return self._answer(lambda _: [])
        return self._answer(
            lambda t: [
                z3.Implies(S[f"{b}.{x}.state"] == HALF, FITS[x](body, S[f"{b}.{x}.half"])),
                *[
                    z3.Implies(
                        z3.And(S[f"{b}.{x}.state"] == LINES, obeys(S, b, x, k)),
                        FITS[x](body, LINE_OF(S[f"{b}.number"], k)),
                    )
                    for k in t.numbers
                ],
            ]
        )

    x = ""  # disk of the robot that asks


def _held_by(held: Any) -> Callable[[Any], Any]:
    """Whether a disk holds a region now."""
    low, high = held.acknowledged, held.granted
    return lambda r: z3.And(low <= r, r <= high)


def apart(x: str, mine: Any, other: Any) -> Any:
    return APART(mine, other) if x == "A" else APART(other, mine)
