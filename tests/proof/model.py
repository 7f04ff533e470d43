"""The model: the state of two disks in the kernel, and the invariant that its rules preserve.

The disks are A, the lower id, and B. Their pair has two bindings, `L` (living) and `S` (static). A state is a
flat record of symbolic numbers and truth values:

- `v`, version of the ledger;
- of a disk X its phase, life, still, acked and granted, and any acknowledgement in transit (`said`);
- of the process of its present life the version received, the newest region offered, the region obeyed,
  its body, the own one without a part, and whether the other disk is that part (`reach`);
- of a binding whether it is in force (`on`), its number, since, asked (0, or one of the two disks), whether a
  first line is in transit (`frozen`), and two answers;
- of each of its ends the life, dead, the version received if that life is over, and the end in its process:
  has, state, half, static, and of the protocol number, seen, held (A, the owner), seen and held (B).

A region stands for its number, and the line of a binding for its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from itertools import pairwise, permutations, product
from types import SimpleNamespace
from typing import Any

import z3

from protocol.kernel.records import ANNOUNCED, GONE, PRESENT
from protocol.kernel.robot import ASKED, HALF, LINES

BODY, LINE = z3.DeclareSort("Body"), z3.DeclareSort("Line")
INT, BOOL = z3.IntSort(), z3.BoolSort()

APART = z3.Function("apart", INT, INT, BOOL)  # regions of A and of B
INSIDE = {x: z3.Function(f"inside{x}", BODY, INT, BOOL) for x in "AB"}
BESIDE = {x: z3.Function(f"beside{x}", INT, LINE, BOOL) for x in "AB"}  # a region, on the side of X
FITS = {x: z3.Function(f"fits{x}", BODY, LINE, BOOL) for x in "AB"}
DISJOINT = z3.Function("disjoint", BODY, BODY, BOOL)
LINE_OF = z3.Function("line", INT, INT, LINE)  # of a binding's number and its own

OTHER = {"A": "B", "B": "A"}

# Universally quantified: regions and bodies of A and of B, a line, and the number of one.
REGION, ANY_BODY = {x: z3.Int(f"any_{x}") for x in "AB"}, {x: z3.Const(f"any body {x}", BODY) for x in "AB"}
ANY_LINE, K = z3.Const("any line", LINE), z3.Int("any_K")
VARIABLES = (*REGION.values(), *ANY_BODY.values(), ANY_LINE, K)


def _of_ids(compares: str) -> Any:
    of_places, of_terms = getattr(int, compares), getattr(z3.ArithRef, compares)
    return lambda one, other: (
        of_places(one.place, other.place) if isinstance(other, Code) else of_terms(one, other)
    )


class Code(z3.ArithRef):
    """A disk's id: any number but 0, with a known place in the order of all ids."""

    def __init__(self, name: str, place: int) -> None:
        super().__init__(z3.Int(name).as_ast())
        self.place = place

    def __hash__(self) -> int:
        return 0

    __eq__, __ne__, __lt__ = map(_of_ids, ("__eq__", "__ne__", "__lt__"))


CODE = {"A": Code("id.A", 3), "B": Code("id.B", 5)}
THIRDS = {  # disks beside A and B, with ids below, between and above, and the kind of their bindings
    Code(f"id.{place}", place): kind
    for place, kind in zip(
        (1, 2, 8, 4, 6, 9, 0), ["asked", "begun", "loose", "asked", "asked", "begun", "loose"], strict=True
    )
}
_IDS = sorted([*CODE.values(), *THIRDS])
IDS = z3.And(*[z3.ArithRef.__lt__(*each) for each in pairwise(_IDS)], *[name != 0 for name in _IDS])

State = Mapping[str, z3.ExprRef]

_KINDS = (
    ("", INT, "v"),
    ("{x}.", INT, "phase life acked granted taken offered obeyed said"),
    ("{x}.", BOOL, "still reach"),
    ("{x}.", BODY, "body own"),
    ("{b}.", INT, "number since asked h s h2 s2"),
    ("{b}.", BOOL, "on frozen"),
    ("{b}.{x}.", INT, "life dead taken state seen held"),
    ("{b}.{x}.", BOOL, "has static"),
    ("{b}.{x}.", LINE, "half"),
    ("{b}.A.", INT, "number"),
)
_FIELDS = [(of + name, sort) for of, sort, names in _KINDS for name in names.split()]
_NAMES = {name.format(b=b, x=x): sort for name, sort in _FIELDS for b, x in product("LS", "AB")}
S: dict[str, z3.ExprRef] = {name: z3.Const(name, sort) for name, sort in _NAMES.items()}  # any state


@cache
def variables_in(claim: z3.BoolRef) -> list[z3.ExprRef]:
    """The variables of a claim."""
    return [term for term in VARIABLES if mentions(claim, term)] if mentions(claim, *VARIABLES) else []


def mentions(claim: z3.BoolRef, *terms: z3.ExprRef) -> bool:
    """Whether a claim mentions any of these terms."""
    return not z3.substitute(claim, *((term, z3.Const("another", term.sort())) for term in terms)).eq(claim)


@cache
def quantified(claim: z3.BoolRef) -> z3.BoolRef:
    """A claim for all values of its variables."""
    terms = variables_in(claim)
    return z3.ForAll(terms, claim) if terms else claim


# -- the state of the kernel's objects, symbolic or concrete


def bindings_of(ledger: Any, low: int = CODE["A"], high: int = CODE["B"]) -> dict[str, Any]:
    """The bindings of two disks that are in force, by kind."""
    both = ledger.pairs[low].get(high)
    kinds = {} if both is None else {"L": both.living, "S": both.static}
    return {b: binding for b, binding in kinds.items() if binding is not None}


def ledger_fields(ledger: Any, low: int = CODE["A"], high: int = CODE["B"]) -> dict[str, Any]:
    """The state of two disks in a ledger."""
    found = {"v": ledger.version}
    for x, name in (("A", low), ("B", high)):
        disk = ledger.disks[name]
        found |= {f"{x}.phase": disk.phase, f"{x}.life": disk.life, f"{x}.still": disk.still}
        found |= {f"{x}.acked": disk.held.acknowledged, f"{x}.granted": disk.held.granted}
    bindings = bindings_of(ledger, low, high)
    found |= {f"{b}.on": b in bindings for b in "LS"}
    for b, binding in bindings.items():
        found |= {f"{b}.{f}": getattr(binding, f) for f in ("number", "since", "asked")}
        for x, end in (("A", binding.low), ("B", binding.high)):
            found |= {f"{b}.{x}.life": end.life, f"{b}.{x}.dead": end.dead}
    return found


def end_fields(b: str, x: str, end: Any) -> dict[str, Any]:
    """The state of an end in its process."""
    key, lines = f"{b}.{x}", end.lines
    found = {f"{key}.has": True, f"{key}.state": end.state, f"{key}.static": end.static}
    if lines is not None:
        found |= {f"{key}.seen": lines.seen, f"{key}.held": lines.held_number}
        found |= {f"{key}.number": lines.number} if x == "A" else {}
    return found if end.half is None else found | {f"{key}.half": end.half}


def process_fields(x: str, process: Any) -> dict[str, Any]:
    """The state of the region that a process obeys, and of its body."""
    kept = {"taken": "version", "offered": "offered_number", "obeyed": "number", "body": "body", "own": "own"}
    return {f"{x}.{name}": getattr(process, field) for name, field in kept.items()}


# -- derived terms


def towards(s: State, x: str) -> z3.ExprRef:
    """The body of X that its lines towards the other disk constrain."""
    return z3.If(s[f"{x}.reach"], s[f"{x}.own"], s[f"{x}.body"])


def real(s: State, x: str) -> z3.ExprRef:
    """The body that X really covers: a present part is not carried yet."""
    other_is_there = s[f"{OTHER[x]}.phase"] == PRESENT
    return z3.If(z3.And(s[f"{x}.reach"], other_is_there), s[f"{x}.own"], s[f"{x}.body"])


def ends(s: State, b: str) -> dict[str, z3.ExprRef]:
    """The protocol's numbers at both ends; initial ones for an end that its process lacks."""
    numbers = {"number": "A.number", "seen": "A.seen", "held": "A.held"}
    numbers |= {"answered": "B.seen", "adopted": "B.held"}
    has = {x: z3.And(s[f"{b}.{x}.has"], s[f"{b}.{x}.state"] != ASKED) for x in "AB"}
    return {name: z3.If(has[of[0]], s[f"{b}.{of}"], 0) for name, of in numbers.items()}


def owner_obeys(s: State, b: str, k: z3.ArithRef) -> z3.BoolRef:
    """Whether the owner obeys the line of number k, if it obeys lines at all."""
    e = ends(s, b)
    return z3.Or(k == e["held"], z3.And(e["seen"] < k, k <= e["number"]))


def obeys(s: State, b: str, x: str, k: z3.ArithRef) -> z3.BoolRef:
    """Whether end X obeys the line of number k, if it obeys lines at all."""
    return owner_obeys(s, b, k) if x == "A" else k == ends(s, b)["adopted"]


def holds(s: State, x: str, r: z3.ArithRef) -> z3.BoolRef:
    """Whether disk X holds the region of number r."""
    return z3.And(s[f"{x}.acked"] <= r, r <= s[f"{x}.granted"])


# -- the invariant


def invariant(s: State) -> dict[str, z3.BoolRef]:
    """Every conjunct, by name."""
    found = _of_pair(s) | _of_disk(s, "A") | _of_disk(s, "B")
    for b in "LS":
        of_binding = _of_end(s, b, "A") | _of_end(s, b, "B") | _of_binding(s, b)
        found |= {f"{b}{name}": z3.Implies(s[f"{b}.on"], claim) for name, claim in of_binding.items()}
    return found


def _fields(s: State, of: str) -> SimpleNamespace:
    """The state of a disk, a binding or one of its ends."""
    mine = [name for name in s if name.startswith(f"{of}.")]
    return SimpleNamespace(**{name.removeprefix(f"{of}."): s[name] for name in mine})


def _of_pair(s: State) -> dict[str, z3.BoolRef]:
    there = z3.And(s["A.phase"] == PRESENT, s["B.phase"] == PRESENT)
    one_moves = z3.Not(z3.And(s["A.still"], s["B.still"]))
    counts = [z3.And(s[f"{b}.on"], s[f"{b}.since"] != 0) for b in "LS"]
    held = [holds(s, x, REGION[x]) for x in "AB"]
    return {
        # The claim: two present disks are disjoint.
        "safe": z3.Implies(there, DISJOINT(real(s, "A"), real(s, "B"))),
        # "All that two present disks hold is apart, or a binding of the two counts, or both stand."
        "regions apart, or bound": z3.Implies(
            z3.And(there, one_moves, *held), z3.Or(APART(*REGION.values()), *counts)
        ),
    }


def _of_disk(s: State, x: str) -> dict[str, z3.BoolRef]:
    v, disk = s["v"], _fields(s, x)
    acked, granted, life, taken, obeyed = disk.acked, disk.granted, disk.life, disk.taken, disk.obeyed
    found = {
        "numbers": z3.And(
            acked > 0, acked <= granted, granted <= v, life >= 0, life <= v, taken >= 0, taken <= v,
            z3.Or(*[disk.phase == phase for phase in (GONE, ANNOUNCED, PRESENT)]),
        ),
        # "A disk without a life stands."
        "no life stands": z3.And(
            z3.Implies(disk.phase != PRESENT, life == 0), z3.Implies(life == 0, disk.still)
        ),
        # "All that a disk holds that stands is its place."
        "still holds a place": z3.Implies(
            disk.still, z3.And(acked == granted, z3.Or(life == 0, granted < life))
        ),
        "moving has a region": z3.Implies(z3.Not(disk.still), life < granted),
        # "A present disk lies in something that it holds."
        "in what it holds": z3.Implies(
            disk.phase != GONE,
            z3.If(
                z3.And(z3.Not(disk.still), obeyed != 0),
                z3.And(acked <= obeyed, obeyed <= granted, life < obeyed, INSIDE[x](disk.body, obeyed)),
                z3.And(INSIDE[x](disk.body, acked), z3.Or(life == 0, acked < life)),
            ),
        ),
        "stands before its first region": z3.Implies(
            z3.And(life != 0, disk.still), z3.And(obeyed == 0, z3.Not(disk.reach))
        ),
        "region from a Tick": z3.And(
            obeyed >= 0, obeyed <= taken, z3.Implies(life == 0, z3.Not(disk.reach)),
            z3.Implies(life != 0, z3.And(disk.offered <= taken, disk.offered <= granted)),
        ),
        # "Only a region that the present life has obeyed is acknowledged, or one of an earlier life."
        "acknowledgement": z3.Or(
            disk.said < acked,
            z3.And(life != 0, z3.Not(disk.still), life < disk.said, disk.said <= obeyed),
        ),
        "of this life": z3.Or(life == 0, taken == 0, life <= taken),
    }  # fmt: skip
    return {f"{x}: {name}": claim for name, claim in found.items()}


def _of_end(s: State, b: str, x: str) -> dict[str, z3.BoolRef]:
    """For one end of a binding in force."""
    y = OTHER[x]
    disk, other, binding = _fields(s, x), _fields(s, y), _fields(s, b)
    end, far = _fields(s, f"{b}.{x}"), _fields(s, f"{b}.{y}")
    since, first, is_asked = binding.since, LINE_OF(binding.number, 0), binding.asked == CODE[x]
    begun = z3.And(end.has, end.state != ASKED)
    newest = z3.If(end.dead == 0, disk.taken, end.taken)  # version that this life has received
    lives = z3.And(end.life == disk.life, disk.life != 0)
    if b == "L":
        lives = z3.And(lives, end.dead == 0)
    else:
        stood = z3.And(disk.still, far.dead == 0, z3.Or(disk.life == 0, end.dead < disk.life))
        lives = z3.If(end.dead == 0, z3.And(lives, far.dead != 0), stood)
    found = {
        "lives": z3.And(disk.phase != GONE, lives),
        "end": z3.And(
            end.life >= 0, end.life < binding.number, end.dead <= s["v"],
            z3.Or(end.dead == 0, binding.number <= end.dead),
            end.state >= ASKED, end.state <= HALF, z3.Implies(end.life == 0, z3.Not(end.has)),
        ),
        # "An end that is asked has a life, and the other stands until the first line is known."
        "asked": z3.Implies(is_asked, z3.If(since == 0, z3.And(other.still, end.dead == 0), begun)),
        # "A life that has received a version in which a binding has its first line has adopted the binding."
        "taken with its version": z3.Implies(z3.And(end.dead == 0, since != 0, since <= disk.taken), begun),
        "taken from a Tick": z3.Implies(
            end.has,
            z3.And(
                binding.number <= newest,
                z3.Or(is_asked, z3.And(since != 0, since <= newest, end.state != ASKED)),
            ),
        ),
        # "All that a disk held when the first line became known is beside it, but of the one that was asked."
        "beside the first line": z3.Implies(
            z3.And(since != 0, end.dead == 0, z3.Not(is_asked), holds(s, x, REGION[x]), REGION[x] < since),
            BESIDE[x](REGION[x], first),
        ),
        # "A body fits all lines that it obeys, and the first one before it knows of it."
        "fits its lines": z3.Implies(
            z3.And(
                z3.Or(since != 0, z3.And(end.has, end.state == LINES)),
                z3.Not(z3.And(end.has, end.state == HALF)),
                obeys(s, b, x, K),
            ),
            FITS[x](towards(s, x), LINE_OF(binding.number, K)),
        ),
        "first line said": z3.Implies(z3.And(binding.frozen, is_asked), begun),
        "frozen": z3.Implies(z3.And(since == 0, begun), BESIDE[y](other.acked, first)),
        # "A half-plane is obeyed only towards what stands."
        "half-plane": z3.Implies(
            z3.And(end.has, end.state == HALF),
            z3.And(end.static, FITS[x](towards(s, x), end.half), BESIDE[y](other.acked, end.half)),
        ),
        "static": z3.Implies(z3.And(end.has, end.static), z3.And(far.dead != 0, far.dead <= newest)),
    }  # fmt: skip
    return {f".{x}: {name}": claim for name, claim in found.items()}


def _of_binding(s: State, b: str) -> dict[str, z3.BoolRef]:
    """For a binding in force, and the numbers of its lines."""
    binding, e = _fields(s, b), ends(s, b)
    number, since, asked = binding.number, binding.since, binding.asked
    answers = [(binding.h, binding.s), (binding.h2, binding.s2)]
    found = {
        "numbers": z3.And(
            number > 0, number <= s["v"], z3.Or(since == 0, z3.And(number <= since, since <= s["v"])),
            z3.Or(*[asked == each for each in (0, *CODE.values())]), z3.Implies(asked == 0, since == number),
        ),
        # "Whichever line the follower obeys, the owner obeys too."
        "the owner obeys what the follower obeys": owner_obeys(s, b, e["adopted"]),
        "order": z3.And(
            e["held"] >= 0, e["held"] <= e["seen"], e["seen"] <= e["answered"],
            e["adopted"] >= 0, e["adopted"] <= e["answered"], e["answered"] <= e["number"],
        ),
        # "Of two answers the later one holds the same line, or one that the earlier had not seen."
        "two answers": z3.And(
            *[
                z3.Implies(seen <= later, z3.Or(newer == held, newer > seen))
                for (held, seen), (newer, later) in permutations(answers)
            ]
        ),
    }  # fmt: skip
    for name, (held, seen) in zip(("h", "h2"), answers, strict=True):
        found[f"answer {name}"] = z3.And(
            held >= 0, held <= seen, seen <= e["answered"],
            z3.Or(e["adopted"] == held, e["adopted"] > seen),
            z3.Or(seen <= e["seen"], owner_obeys(s, b, held)),
        )  # fmt: skip
    return {f": {name}": claim for name, claim in found.items()}


# -- geometry


def axioms() -> list[z3.BoolRef]:
    """Axioms of ids, and of all bodies, regions and lines."""
    inside = {x: INSIDE[x](ANY_BODY[x], REGION[x]) for x in "AB"}
    fits = {x: FITS[x](ANY_BODY[x], ANY_LINE) for x in "AB"}
    disjoint = DISJOINT(*ANY_BODY.values())
    return [
        IDS,
        *[z3.Implies(z3.And(inside[x], BESIDE[x](REGION[x], ANY_LINE)), fits[x]) for x in "AB"],
        z3.Implies(z3.And(APART(*REGION.values()), *inside.values()), disjoint),
        z3.Implies(z3.And(*fits.values()), disjoint),
    ]


def smaller(x: str, small: Any, large: Any) -> list[z3.BoolRef]:
    """One body of X is a subset of another: it keeps to everything that the larger one keeps to."""
    one, other = ([{**ANY_BODY, x: body}[y] for y in "AB"] for body in (small, large))
    return [
        z3.Implies(INSIDE[x](large, REGION[x]), INSIDE[x](small, REGION[x])),
        z3.Implies(FITS[x](large, ANY_LINE), FITS[x](small, ANY_LINE)),
        z3.Implies(DISJOINT(*other), DISJOINT(*one)),
    ]
