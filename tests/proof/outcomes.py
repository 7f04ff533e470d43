"""The outcome of one path through a rule: the state after it, and the answers of the geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import z3

from protocol.kernel.robot import HALF, LINES
from tests.proof.model import ANY_LINE, APART, BESIDE, CODE, FITS, INSIDE, LINE_OF, OTHER, REGION, K, S, obeys

NAMES = {CODE[x]: x for x in "AB"}
NEXT = S["v"] + 1
PART, EPOCH = z3.Int("part"), z3.Int("epoch")
PROPOSED = z3.Int("proposed")
OBEYED = {b: z3.Int(f"{b}.any line") for b in "LS"}  # number of any line of a binding
SAID = {x: z3.Int(f"{x}.also said") for x in "AB"}  # region of any acknowledgement in transit
HELD = {x: z3.Int(f"{x}.any held") for x in "AB"}  # number of any region


def any_body(name: str) -> Any:
    """A body that a rule introduces."""
    return z3.Const(name, S["A.body"].sort())


class Outcome:
    """The outcome of one path through one rule.

    Attributes:
        after: the state.
        assumptions: besides the invariant and the path condition.
        claims: besides the invariant, by name.
    """

    def __init__(self, geometry: Geometry | None = None) -> None:
        self.after: dict[str, Any] = dict(S)
        self.assumptions: list[Any] = [] if geometry is None else geometry.assumptions
        self.claims: dict[str, Any] = {}

    def assume(self, *assumptions: Any) -> None:
        """Add assumptions."""
        self.assumptions += assumptions

    def stands(self, x: str, body: Any) -> None:
        """X covers this body, and reaches for no part."""
        self.after[f"{x}.body"] = self.after[f"{x}.own"] = body
        self.after[f"{x}.reach"] = False

    def begins(self, x: str) -> None:
        """The process of X is new, without any Tick."""
        for kept in ("taken", "offered", "obeyed"):
            self.after[f"{x}.{kept}"] = 0


@dataclass
class Case:
    """One rule.

    Attributes:
        rule: its name.
        run: executes it.
        given: what its caller ensures.
        starts: whether there is no state before it.
    """

    rule: str
    run: Callable[[], Outcome]
    given: list[Any] = field(default_factory=list)
    starts: bool = False


class Geometry:
    """Geometry with answers of the solver's choice. A positive answer implies a fact about every region held,
    stated of variables alone, as solvers find those in the claims.
    """

    def __init__(self) -> None:
        self.assumptions: list[Any] = []
        self._count = 0
        fields = {"phase": "phase", "acknowledged": "acked", "granted": "granted"}
        before = {x: {name: S[f"{x}.{f}"] for name, f in fields.items()} for x in "AB"}
        self.noted = {x: SimpleNamespace(**before[x], regions=None) for x in "AB"}
        self.disks: dict[Any, Any] = {}
        self.x = ""  # disk of the robot that asks

    def _answer(self, *says: Any) -> z3.BoolRef:
        self._count += 1
        answer = z3.Bool(f"answer{self._count}")
        self.assumptions += [z3.Implies(answer, each) for each in says]
        return answer

    def _answer_of(self, says: Any, *helds: Any) -> z3.BoolRef:
        """A positive answer implies this of every region that disks hold, except third ones."""
        if not all(held.disk for held in helds):
            return self._answer()
        assert len({held.disk for held in helds}) == len(helds), "a disk is compared with itself"
        return self._answer(z3.Implies(z3.And(*map(_is_held, helds)), says))

    # for the ledger

    def note(self, disk: Any) -> None:
        noted = vars(disk.held) | {"phase": disk.phase, "regions": [*disk.held.regions]}
        self.noted[NAMES[disk.name]] = SimpleNamespace(**noted)

    def around(self, disk: Any, region: Any) -> list[int]:
        """A disk that is not listed holds nothing that meets the region, or a region of `disk`."""
        other = self.disks[CODE[OTHER[NAMES[disk.name]]]]
        far = z3.And(self.clear(other.held, region), self.apart(other.held, disk.held))
        return [name for name in self.disks if name != other.name or not far]

    def apart(self, one: Any, other: Any) -> z3.BoolRef:
        return one is not other and self._answer_of(APART(*REGION.values()), one, other)

    def clear(self, held: Any, region: Any) -> z3.BoolRef:
        y = OTHER.get(held.disk)
        return self._answer_of(y and z3.Implies(REGION[y] == region, APART(*REGION.values())), held)

    def beside(self, held: Any, line: Any, low: bool) -> z3.BoolRef:
        assert low == (held.disk == "A")
        return self._answer_of(BESIDE[held.disk](REGION[held.disk], line), held)

    def within(self, place: Any, held: Any) -> z3.BoolRef:
        x, y = held.disk, OTHER[held.disk]
        around, it_is = z3.Int(f"around{x}"), REGION[x] == place
        return self._answer(
            z3.substitute(_is_held(held), (REGION[x], around)),
            z3.Implies(z3.And(it_is, BESIDE[x](around, ANY_LINE)), BESIDE[x](REGION[x], ANY_LINE)),
            z3.Implies(z3.And(it_is, apart(x, around, REGION[y])), APART(*REGION.values())),
        )

    # for a robot

    def inside(self, body: Any, region: Any) -> z3.BoolRef:
        return INSIDE[self.x](body, region)

    def fits(self, body: Any, line: Any, low: bool) -> z3.BoolRef:
        assert low == (self.x == "A")
        return FITS[self.x](body, line)

    def behind(self, place: Any, line: Any, low: bool) -> z3.BoolRef:
        assert low == (self.x == "B")
        return BESIDE[OTHER[self.x]](place, line)

    def keeps(self, body: Any, end: Any) -> z3.BoolRef:
        x, b = self.x, end.of
        if not b:
            return self._answer()
        state, number = S[f"{b}.{x}.state"], S[f"{b}.number"]
        return self._answer(
            z3.Implies(state == HALF, FITS[x](body, S[f"{b}.{x}.half"])),
            z3.Implies(z3.And(state == LINES, obeys(S, b, x, K)), FITS[x](body, LINE_OF(number, K))),
        )


def _is_held(held: Any) -> z3.BoolRef:
    """Whether a disk holds its region variable now."""
    region = REGION[held.disk]
    return z3.And(held.acknowledged <= region, region <= held.granted)


def apart(x: str, mine: Any, other: Any) -> Any:
    return APART(mine, other) if x == "A" else APART(other, mine)
