"""The kernel's own source, and its objects built from a symbolic state."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import z3

from protocol.kernel.records import ANNOUNCED, GONE, PRESENT
from protocol.kernel.robot import ASKED, HALF, LINES
from tests.interpreted import Edit, interpreted
from tests.proof import symbolic
from tests.proof.containers import Frame, SymbolicList, with_optional
from tests.proof.model import CODE, LINE, LINE_OF, OTHER, THIRDS, Code, bindings_of, ledger_fields, obeys
from tests.proof.outcomes import HELD, NAMES, OBEYED, SAID, Geometry, Outcome, S


class Source:
    """The modules of the kernel, as loaded last."""

    records: Any
    pair: Any
    ledger: Any
    robot: Any

    def read(self, edits: Sequence[Edit] = ()) -> None:
        """Load the kernel's source, or an edited copy."""
        names = [f"protocol.kernel.{name}" for name in ("records", "pair", "ledger", "robot")]
        self.records, self.pair, self.ledger, self.robot = interpreted(*names, edits=edits)
        for module in (self.pair, self.ledger, self.robot):
            assert module.require is self.records.require
            module.require = symbolic.require


SOURCE = Source()
SOURCE.read()


def held_of(x: str) -> Any:
    """The regions that a disk holds: the first, the newest, and any in between."""
    acked, granted, held = S[f"{x}.acked"], S[f"{x}.granted"], SOURCE.records.Held(0, None)

    def regions() -> list[Any]:
        between = [r for r in (SAID[x], HELD[x]) if z3.And(acked < r, r < granted)]
        numbers = [acked, *between, *([granted] if acked < granted else [])]
        return [(r, r) for r in numbers]

    held.acknowledged, held.granted, held.regions = acked, granted, SymbolicList(regions)
    held.disk = x
    return held


def holds_its_regions(held: Any, x: str) -> Any:
    """Whether a disk holds exactly the regions of its state, each with its number."""
    acked, granted = held.acknowledged, held.granted
    regions = list(held.regions)
    kept = z3.And(S[f"{x}.acked"] <= HELD[x], HELD[x] <= S[f"{x}.granted"], acked <= HELD[x])
    return z3.And(
        *[number == acked for number, _ in regions[:1]],
        *[number == granted for number, _ in regions[-1:]],
        bool(regions),
        *[z3.And(number == region, acked <= number, number <= granted) for number, region in regions],
        z3.Implies(kept, z3.Or(*[number == HELD[x] for number, _ in regions])),
    )


def disk_of(name: Code) -> Any:
    x = NAMES[name]
    disk = SOURCE.records.DiskRecord(name, held_of(x), 0)
    disk.phase, disk.life = S[f"{x}.phase"], S[f"{x}.life"]
    disk.still = S[f"{x}.still"]
    return disk


def binding_of(b: str) -> Any:
    low, high = (SOURCE.records.End(CODE[x], S[f"{b}.{x}.life"], S[f"{b}.{x}.dead"]) for x in "AB")
    binding = SOURCE.records.Binding(S[f"{b}.number"], low, high, S[f"{b}.asked"], None)
    binding.since, binding.of = S[f"{b}.since"], b
    return with_optional(binding, first=(LINE_OF(S[f"{b}.number"], 0), binding.since != 0))


def ledger_of(geometry: Geometry, changing: str = "") -> Any:
    """The ledger of the state, in which these paths may change besides bindings; one execution path for each
    set of bindings in force. Two disks without bindings may have none with third ones, either.
    """
    made = SOURCE.ledger.Ledger(0, {}, geometry)
    made.version = S["v"]
    names = [*THIRDS]
    names[3:3] = CODE.values()
    geometry.disks = made.disks = {name: (third_of if name in THIRDS else disk_of)(name) for name in names}
    made.pairs = {name: {} for name in names}
    both = pair_of()
    alone = both is None and bool(z3.Bool("alone"))
    for other, one in product(names, NAMES):
        pair = both if other in NAMES else None if alone else pair_with_third(one, other)
        if one != other and pair is not None:
            made.pairs[one][other] = made.pairs[other][one] = pair
    made.frame = Frame(made, f"version|frame|pairs/id.[AB]/id.[AB](/.*)?|{changing}")
    return made


def pair_of() -> Any:
    """The pair of A and B; two disks that were bound and are still there have one without bindings."""
    living, static = (bool(S[f"{b}.on"]) for b in "LS")
    if not (living or static or z3.And(z3.Bool("was bound"), *[S[f"{x}.phase"] != GONE for x in "AB"])):
        return None
    both = SOURCE.ledger.Pair()
    both.living = binding_of("L") if living else None
    both.static = binding_of("S") if static else None
    return both


def third_of(name: Code) -> Any:
    """A disk besides A and B; no claim concerns it."""
    held = SOURCE.records.Held(2, z3.Int("third.region"))
    held.disk, held.regions = "", (*held.regions,)
    disk = SOURCE.records.DiskRecord(name, held, {4: ANNOUNCED, 6: GONE}.get(name.place, PRESENT))
    disk.life, disk.still = z3.Int("third.life"), z3.Bool("third.still")
    return disk


def pair_with_third(name: Code, third: Code) -> Any:
    """The pair of a third disk with A or B: one that the third is asked for, and an older one towards its
    place; one that both obey; or one that only the third obeys, towards an earlier place.
    """
    both, life = SOURCE.ledger.Pair(), S[f"{NAMES[name]}.life"]
    line = z3.Const(f"{name}-{third}.line", LINE)

    def binding(number: int, mine: tuple[Any, int], other: tuple[Any, int], *first: Any) -> Any:
        ends = {name: SOURCE.records.End(name, *mine), third: SOURCE.records.End(third, *other)}
        return SOURCE.records.Binding(z3.IntVal(number), *[ends[each] for each in sorted(ends)], *first)

    if THIRDS[third] == "asked":
        both.living = binding(2, (life, 0), (1, 0), third, None)
        both.static = binding(1, (life, 0), (1, 2), 0, line)
    elif THIRDS[third] == "begun":
        both.living = binding(2, (life, 0), (1, 0), 0, line)
    else:
        both.static = binding(2, (0, 2), (1, 0), 0, line)
    return both


def treated(made: Any, name: int, third: int) -> list[Any]:
    """Effects of a rule on a disk's bindings with a third one, comparable between third ones."""
    pair = made.pairs[name].get(third)
    found: list[Any] = [pair is made.pairs[third].get(name), pair is None]
    for b, binding in bindings_of(made, name, third).items():
        mine, other = sorted((binding.low, binding.high), key=lambda end: bool(end.disk != name))
        found += [b, *map(str, (binding.since, mine.dead, other.dead))]
    return found


def outcome_of(made: Any, geometry: Geometry) -> Outcome:
    """The outcome of a rule of the ledger."""
    outcome = Outcome(geometry)
    outcome.after, outcome.claims = ledger_state(made), ledger_claims(made)
    return outcome


def ledger_state(made: Any) -> dict[str, Any]:
    """The state of the ledger after a rule."""
    after = dict(S)
    for b, binding in bindings_of(made).items():
        after |= _goes_along(b, binding)
    return after | ledger_fields(made)


def ledger_claims(made: Any) -> dict[str, Any]:
    """The ledger's objects agree with its state, and nothing else changes."""
    both = made.pairs[CODE["A"]].get(CODE["B"])
    found = {
        "both disks know the pair": both is made.pairs[CODE["B"]].get(CODE["A"]),
        "only disks that are there are a pair": both is None
        or z3.And(*[made.disks[name].phase != GONE for name in NAMES]),
        "others are treated alike": all(
            treated(made, name, one) == treated(made, name, third)
            for name, one, third in product(NAMES, THIRDS, THIRDS)
            if THIRDS[one] == THIRDS[third]
        ),
        "there are no other disks": {*made.disks} == {*NAMES, *THIRDS},
        "nothing else changes": made.frame.holds,
        **own_claims(made),
    }
    for x in "AB":
        if {(f"id.{x}",), (f"id.{x}", "held")} & {place[1:3] for place in made.frame.changed}:
            found[f"{x}: regions"] = holds_its_regions(made.disks[CODE[x]].held, x)
    for binding in bindings_of(made).values():
        found[f"{binding.number} has its first line"] = _has_its_first_line(binding)
        found[f"{binding.number} has its ends"] = z3.And(
            binding.low.disk == CODE["A"], binding.high.disk == CODE["B"]
        )
    return found


def _has_its_first_line(binding: Any) -> Any:
    since = binding.since != 0
    if "first" not in vars(binding):  # no rule has looked at it
        return since == (S[f"{binding.of}.since"] != 0)
    return z3.If(since, z3.Or(binding.first == LINE_OF(binding.number, 0)), binding.first is None)


def own_claims(made: Any) -> dict[str, Any]:
    """Each disk has its name, and shares no regions, bindings or ends with others."""
    ends = [end for each in bindings_of(made).values() for end in (each.low, each.high)]
    own = [*[made.disks[name].held for name in NAMES], *ends, *made.pairs.values()]
    named = [made.disks[name].name == name for name in NAMES]
    named += [[*made.pairs] == [*made.disks]]
    named += [name not in pairs and {*pairs} <= {*made.disks} for name, pairs in made.pairs.items()]
    return {"each disk has its own": z3.And(len({*map(id, own)}) == len(own), *named)}


def _goes_along(b: str, binding: Any) -> dict[str, Any]:
    """Messages of a binding and its ends in processes, after a rule of the ledger."""
    before, state = getattr(binding, "of", None), {}
    if before is None:
        state = {f"{b}.{x}.has": False for x in "AB"} | {f"{b}.frozen": False}
        state |= {f"{b}.{x}.state": ASKED for x in "AB"}
        state |= {f"{b}.{f}": 0 for f in ("h", "s", "h2", "s2")}
    elif before != b:  # it has become the other kind
        state = {
            f"{b}{name.removeprefix(before)}": S[name]
            for name in S
            if name.startswith(f"{before}.") and not name.endswith(".on")
        }
        state |= {f"{b}.{x}.taken": S[f"{x}.taken"] for x in "AB"}  # by processes whose lives may be over
    return state


def end_of(b: str, x: str, place: Any = None) -> Any:
    """An end in its process, towards the given place or the present one."""
    y, number = OTHER[x], S[f"{b}.number"]
    end = SOURCE.robot.OwnEnd(SOURCE.records.Listed(number, CODE[y], None, None, False), x == "A")
    if S[f"{b}.{x}.state"] != ASKED:
        end.begin(LINE_OF(number, S[f"{b}.{x}.held"]))
        end.lines.seen = S[f"{b}.{x}.seen"]
        end.lines.held_number = S[f"{b}.{x}.held"]
        if x == "A":
            end.lines.number, end.lines.open = S[f"{b}.A.number"], SymbolicList(lambda: _open(b))
    end.of, end.state, end.static = b, S[f"{b}.{x}.state"], S[f"{b}.{x}.static"]
    place = S[f"{y}.acked"] if place is None else place
    half = S[f"{b}.{x}.half"], end.state == HALF
    return with_optional(end, place=(place, z3.Bool(f"{x}.place")), half=half)


def _open(b: str) -> list[Any]:
    """Any open proposal of a binding, and the one that an answer names."""
    last, seen = S[f"{b}.A.number"], S[f"{b}.A.seen"]
    numbers = [k for k in (S[f"{b}.h2"], OBEYED[b]) if z3.And(seen < k, k <= last)]
    return [(k, LINE_OF(S[f"{b}.number"], k)) for k in numbers]


def end_claims(end: Any, after: dict[str, Any], b: str, x: str) -> dict[str, Any]:
    """An end obeys exactly the lines of its state."""
    number, state, half = S[f"{b}.number"], after[f"{b}.{x}.state"], after[f"{b}.{x}.half"]
    lines, kind = end.obeyed, SOURCE.pair.Owner if x == "A" else SOURCE.pair.Follower
    any_line = LINE_OF(number, OBEYED[b])
    obeyed = z3.Implies(obeys(after, b, x, OBEYED[b]), z3.Or(False, *[line == any_line for line in lines]))
    known = [(after[f"{b}.{x}.held"], end.lines.held)] if end.lines is not None else []
    known += [(k, line) for k, line in getattr(end.lines, "open", ())]
    numbered = [z3.And(line == LINE_OF(number, k), obeys(after, b, x, k)) for k, line in known]
    is_known = z3.And(len(lines) == len(known), *numbered)
    is_half = z3.And(len(lines) == 1, *[line == half for line in lines])
    return {
        f"{b}.{x}: keeps what its state says": z3.And(
            (state != ASKED) == isinstance(end.lines, kind), (state == HALF) == (end.half is not None)
        ),
        f"{b}.{x}: obeys its lines": z3.Implies(state == LINES, z3.And(obeyed, is_known)),
        f"{b}.{x}: obeys one half-plane": z3.Implies(state == HALF, is_half),
    }


UNKNOWN, _PEER, _STATIC = z3.Int("unknown"), z3.Int("unknown.peer"), z3.Bool("unknown.static")
EARLIER = {x: z3.And(_STATIC, CODE[OTHER[x]] == _PEER) for x in "AB"}  # it is towards an earlier life


def unknown_of(x: str) -> Any:
    """An end of a binding that is over, or towards a third disk; it may be anything."""
    listed = SOURCE.records.Listed(UNKNOWN, _PEER, z3.Const("unknown.line", LINE), None, _STATIC)
    end = SOURCE.robot.OwnEnd(listed, x == "A")
    end.of, end.state = "", z3.Int("unknown.state")
    place, half = z3.Int("unknown.place"), z3.Const("unknown.half", LINE)
    return with_optional(end, place=(place, end.state == HALF), half=(half, end.state == HALF))


def robot_of(x: str, geometry: Geometry, bounds: Sequence[Any]) -> Any:
    """The process of the present life of X, with these ends of bindings in force, and any other."""
    made = SOURCE.robot.RobotLife(CODE[x], S[f"{x}.life"], S[f"{x}.body"], geometry)
    made.own = S[f"{x}.own"]
    made.part = z3.If(S[f"{x}.reach"], CODE[OTHER[x]], z3.If(CODE[OTHER[x]] == _PEER, 0, _PEER))
    made.version, made.number = S[f"{x}.taken"], S[f"{x}.obeyed"]
    made.offered_number = S[f"{x}.offered"]
    unknown = [unknown_of(x)] if z3.Bool("is unknown") else []
    made.ends = {end.number: end for end in [*bounds, *unknown]}
    geometry.x = x
    is_offered = z3.Or(made.number != 0, made.offered_number != 0)
    regions = {"region": (made.number, made.number != 0), "offered": (made.offered_number, is_offered)}
    with_optional(made, **regions)
    return made
