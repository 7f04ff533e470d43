"""Every rule of the kernel as it runs, on a state that the solver chooses: the source itself, not a copy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import z3

from tests.interpreted import Edit, interpreted
from tests.proof import symbolic
from tests.proof.model import (
    APART,
    ASKED,
    BESIDE,
    BODY,
    CODE,
    DISJOINT,
    FITS,
    GONE,
    HALF,
    INSIDE,
    LINE,
    LINE_OF,
    LINES,
    OTHER,
    PRESENT,
    State,
    ends,
    fresh,
    obeys,
    real,
    smaller,
)
from tests.proof.symbolic import Number, Truth, expression

records: Any = None
pair: Any = None
ledger: Any = None
robot: Any = None


def load(edits: Sequence[Edit] = ()) -> None:
    """Read the kernel's source, or what it would be with a few words changed."""
    global records, pair, ledger, robot  # the rules below run what was read last
    names = [f"protocol.kernel.{name}" for name in ("records", "pair", "ledger", "robot")]
    records, pair, ledger, robot = interpreted(*names, edits=edits)
    for module in (pair, ledger, robot):
        module.require = symbolic.require


load()

NAMES = {1: "A", 2: "B"}
S = fresh("")
NEXT = S["v"] + 1
PART, EPOCH = z3.Int("part"), z3.Int("epoch")
ANY_LINE = z3.Const("any line", LINE)


@dataclass
class Terms:
    """The terms for which quantified facts are written out."""

    bodies: dict[str, list[Any]] = field(default_factory=lambda: {"A": [], "B": []})
    regions: dict[str, list[Any]] = field(default_factory=lambda: {"A": [], "B": []})
    lines: list[Any] = field(default_factory=list)
    numbers: list[Any] = field(default_factory=list)


Facts = Callable[[Terms], list[Any]]


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
        self.facts.append(lambda t: smaller(x, small, large, t.bodies[OTHER[x]], t.regions[x], t.lines))

    def stands_at(self, x: str, body: Any, region: Any) -> None:
        """The body of X is within a region, and no part is reached for."""
        self.after[f"{x}.body"] = self.after[f"{x}.own"] = body
        self.after[f"{x}.reach"] = z3.BoolVal(False)
        self.terms.bodies[x].append(body)
        self.terms.regions[x].append(region)

    def begins(self, x: str) -> None:
        """A process that has heard nothing."""
        for kept in ("taken", "offered", "obeyed"):
            self.after[f"{x}.{kept}"] = z3.IntVal(0)


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


class Geometry:
    """Answers that the solver chooses; a yes says something of every region held."""

    def __init__(self) -> None:
        self.facts: list[Facts] = []
        self.terms = Terms()
        self._count = 0
        self.noted = {x: {f: S[f"{x}.{f}"] for f in ("acked", "granted", "phase")} for x in "AB"}
        self.disks: dict[int, Any] = {}

    def _answer(self, says: Facts) -> Truth:
        self._count += 1
        answer = z3.Bool(f"answer{self._count}")
        self.facts.append(lambda terms: [z3.Implies(answer, each) for each in says(terms)])
        return Truth(answer)

    # of the ledger

    def note(self, disk: Any) -> None:
        held = disk.held
        noted = {"acked": held.acknowledged, "granted": held.granted, "phase": disk.phase}
        self.noted[NAMES[disk.name]] = {field: expression(value) for field, value in noted.items()}

    def around(self, disk: Any, region: Any) -> list[int]:
        """A disk that is not named holds nothing that meets the region, or what the disk holds."""
        x = NAMES[disk.name]
        other = self.disks[CODE[OTHER[x]]]
        named = z3.Bool(f"{OTHER[x]} is around")

        def says(t: Terms) -> list[Any]:
            mine = [region, *t.regions[x]]
            return [
                z3.Implies(
                    z3.And(z3.Not(named), _in(other.held, r), z3.Or(q is region, _in(disk.held, q))),
                    _apart(x, q, r),
                )
                for q in mine
                for r in t.regions[OTHER[x]]
            ]

        self.facts.append(says)
        return [disk.name, other.name] if Truth(named) else [disk.name]

    def apart(self, one: Any, other: Any) -> Truth:
        if one is other:
            return Truth(z3.BoolVal(False))
        mine = {one.disk: one, other.disk: other}
        a, b = mine["A"], mine["B"]
        return self._answer(
            lambda t: [
                z3.Implies(z3.And(_in(a, ra), _in(b, rb)), APART(ra, rb))
                for ra in t.regions["A"]
                for rb in t.regions["B"]
            ]
        )

    def clear(self, held: Any, region: Any) -> Truth:
        x = held.disk
        return self._answer(lambda t: [z3.Implies(_in(held, r), _apart(x, r, region)) for r in t.regions[x]])

    def beside(self, held: Any, line: Any, low: bool) -> Truth:
        assert low == (held.disk == "A")
        return self._answer(
            lambda t: [z3.Implies(_in(held, r), BESIDE[held.disk](r, line)) for r in t.regions[held.disk]]
        )

    def within(self, place: Any, held: Any) -> Truth:
        x = held.disk
        around = z3.Int(f"around{x}")
        self.terms.regions[x].append(around)
        return self._answer(
            lambda t: [
                _in(held, around),
                *[z3.Implies(BESIDE[x](around, line), BESIDE[x](place, line)) for line in t.lines],
                *[z3.Implies(_apart(x, around, r), _apart(x, place, r)) for r in t.regions[OTHER[x]]],
            ]
        )

    # of a robot

    def inside(self, body: Any, region: Any) -> Truth:
        return Truth(INSIDE[self.x](body, region))

    def fits(self, body: Any, line: Any, low: bool) -> Truth:
        assert low == (self.x == "A")
        return Truth(FITS[self.x](body, line))

    def behind(self, place: Any, line: Any, low: bool) -> Truth:
        assert low == (self.x == "B")
        return Truth(BESIDE[OTHER[self.x]](expression(place), line))

    def keeps(self, body: Any, bound: Any) -> Truth:
        x, b = self.x, bound.of
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


def _in(held: Any, r: Any) -> Any:
    return z3.And(held.low <= r, r <= held.high)


def _apart(x: str, mine: Any, other: Any) -> Any:
    return APART(mine, other) if x == "A" else APART(other, mine)


# -- the product's objects, made of the state


def held_of(x: str) -> Any:
    held = records.Held(0, None)
    held.acknowledged, held.granted = Number(S[f"{x}.acked"]), Number(S[f"{x}.granted"])
    held.regions = [(0, S[f"{x}.acked"])]  # the first of them; geometry speaks of all
    held.disk, held.low, held.high = x, S[f"{x}.acked"], S[f"{x}.granted"]
    return held


def disk_of(x: str) -> Any:
    disk = records.DiskRecord(CODE[x], held_of(x), 0)
    disk.phase, disk.life = Number(S[f"{x}.phase"]), Number(S[f"{x}.life"])
    disk.still = Truth(S[f"{x}.still"])
    return disk


def binding_of(b: str) -> Any:
    low, high = (records.End(CODE[x], Number(S[f"{b}.{x}.life"]), Number(S[f"{b}.{x}.dead"])) for x in "AB")
    binding = records.Binding(Number(S[f"{b}.number"]), low, high, Number(S[f"{b}.asked"]), None)
    binding.told = Number(S[f"{b}.told"])
    binding.first = LINE_OF(S[f"{b}.number"], 0)
    binding.of = b
    return binding


def ledger_of(geometry: Geometry) -> Any:
    """The ledger of the state; a way through it for each of the bindings that may be in force."""
    made = ledger.Ledger(0, {}, geometry)
    made.version = Number(S["v"])
    made.disks = geometry.disks = {CODE[x]: disk_of(x) for x in "AB"}
    made.pairs = {1: {}, 2: {}}
    living, static = (bool(Truth(S[f"{b}.on"])) for b in "LS")
    if living or static:
        both = made.pairs[1][2] = made.pairs[2][1] = ledger.Pair()
        both.living = binding_of("L") if living else None
        both.static = binding_of("S") if static else None
    return made


def ledger_state(made: Any) -> dict[str, Any]:
    """The state that the ledger has become."""
    after = dict(S)
    after["v"] = expression(made.version)
    for x in "AB":
        disk = made.disks[CODE[x]]
        after[f"{x}.phase"], after[f"{x}.life"] = expression(disk.phase), expression(disk.life)
        after[f"{x}.still"] = expression(disk.still)
        after[f"{x}.acked"] = expression(disk.held.acknowledged)
        after[f"{x}.granted"] = expression(disk.held.granted)
    both = made.pairs[1].get(2)
    for b, slot in (("L", "living"), ("S", "static")):
        binding = None if both is None else getattr(both, slot)
        after[f"{b}.on"] = z3.BoolVal(binding is not None)
        if binding is not None:
            after |= _binding_state(b, binding)
    return after


def _binding_state(b: str, binding: Any) -> dict[str, Any]:
    before, state = getattr(binding, "of", None), {}
    if before is None:
        state = {f"{b}.{x}.has": z3.BoolVal(False) for x in "AB"} | {f"{b}.frozen": z3.BoolVal(False)}
        state |= {f"{b}.{x}.state": z3.IntVal(ASKED) for x in "AB"}
        state |= {f"{b}.{f}": z3.IntVal(0) for f in ("h", "s", "h2", "s2")}
    elif before != b:  # it has become the other kind
        state = {
            f"{b}{name.removeprefix(before)}": S[name]
            for name in S
            if name.startswith(f"{before}.") and not name.endswith(".on")
        }
    state[f"{b}.number"], state[f"{b}.told"] = expression(binding.number), expression(binding.told)
    state[f"{b}.asked"] = expression(binding.asked)
    for x, end in (("A", binding.low), ("B", binding.high)):
        state[f"{b}.{x}.life"], state[f"{b}.{x}.dead"] = expression(end.life), expression(end.dead)
        if before != b and before is not None:  # a process whose life may be over
            state[f"{b}.{x}.taken"] = S[f"{x}.taken"]
    return state


def bound_of(b: str, x: str, *, lines: bool = True) -> Any:
    """An end that was taken; with its lines, if there are any, where a rule may ask for them."""
    y, number = OTHER[x], S[f"{b}.number"]
    bound = robot.Bound(records.Listed(Number(number), CODE[y], None, None, False), x == "A")
    if lines and Truth(S[f"{b}.{x}.state"] != ASKED):
        bound.begin(LINE_OF(number, 0))
        bound.lines.seen = Number(S[f"{b}.{x}.seen"])
        bound.lines.held_number = Number(S[f"{b}.{x}.held"])
        if x == "A":
            bound.lines.number = Number(S[f"{b}.A.number"])
    bound.of, bound.state = b, Number(S[f"{b}.{x}.state"])
    bound.static, bound.place = Truth(S[f"{b}.{x}.static"]), S[f"{y}.acked"]
    bound.half = S[f"{b}.{x}.half"]
    return bound


def bound_state(bound: Any, after: dict[str, Any], b: str, x: str) -> None:
    """The state that an end has become."""
    after[f"{b}.{x}.has"], after[f"{b}.{x}.state"] = z3.BoolVal(True), expression(bound.state)
    after[f"{b}.{x}.static"] = expression(bound.static)
    if bound.lines is not None:
        after[f"{b}.{x}.seen"] = expression(bound.lines.seen)
        after[f"{b}.{x}.held"] = expression(bound.lines.held_number)
        if x == "A":
            after[f"{b}.A.number"] = expression(bound.lines.number)
    if bound.half is not None:
        after[f"{b}.{x}.half"] = bound.half


def robot_of(x: str, geometry: Geometry, bounds: Sequence[Any] = ()) -> Any:
    """The process of the present life of X."""
    made = robot.RobotLife(CODE[x], Number(S[f"{x}.life"]), S[f"{x}.body"], geometry)
    made.own = S[f"{x}.own"]
    made.part = Number(z3.If(S[f"{x}.reach"], CODE[OTHER[x]], 0))
    made.version, made.number = Number(S[f"{x}.taken"]), Number(S[f"{x}.obeyed"])
    made.offered_number, made.offered = Number(S[f"{x}.offered"]), S[f"{x}.offered"]
    made.bound = {bound.number: bound for bound in bounds}
    geometry.x = x
    return made


# -- rules of the ledger

Rule = Callable[[Any, Any, Any], object]  # of the ledger, the disk and the other one
Besides = Callable[[str, Outcome], None]  # what else happens to the disk


def of_ledger(rule: str, does: Rule, x: str, besides: Besides | None = None) -> Case:
    """A rule of the ledger whose first disk is X."""

    def run() -> Outcome:
        geometry = Geometry()
        made = ledger_of(geometry)
        does(made, made.disks[CODE[x]], made.disks[CODE[OTHER[x]]])
        outcome = Outcome(geometry)
        outcome.after = ledger_state(made)
        outcome.claims = history(outcome.after) | noted(geometry, outcome.after)
        if besides is not None:
            besides(x, outcome)
        return outcome

    return Case(f"{rule} {x}", run)


def history(after: State) -> dict[str, Any]:
    """What makes a Tick of an earlier version tell each binding in force as it was then: a binding changes
    once at most in each of its fields, at a version that the field keeps."""
    v, version = S["v"], after["v"]
    changed = [f"{x}.{f}" for x in "AB" for f in ("phase", "life", "still", "granted")]
    changed += [f"{b}.{f}" for b in "LS" for f in ("on", "number", "told", "A.dead", "B.dead")]
    found = {
        "a change has a version": z3.And(
            version >= v, z3.Or(version > v, *[z3.And(*[after[f] == S[f] for f in changed])])
        )
    }
    for x in "AB":
        found[f"{x}: regions are numbered upwards"] = after[f"{x}.granted"] >= S[f"{x}.granted"]
    for b in "LS":
        new = z3.And(
            after[f"{b}.number"] == version,
            z3.Or(after[f"{b}.told"] == 0, after[f"{b}.told"] == version),
            *[z3.Or(after[f"{b}.{x}.dead"] == 0, after[f"{b}.{x}.dead"] == version) for x in "AB"],
        )
        same = z3.Or(*[z3.And(S[f"{old}.on"], *_goes_on(after, b, old)) for old in "LS"])
        found[f"{b}: is new or goes on"] = z3.Implies(after[f"{b}.on"], z3.Or(new, same))
    return found


def noted(geometry: Geometry, after: State) -> dict[str, Any]:
    """What geometry was told last covers all that each disk holds."""
    return {
        f"{x}: is noted": z3.Implies(
            after[f"{x}.phase"] != GONE,
            z3.And(
                geometry.noted[x]["phase"] != GONE,
                geometry.noted[x]["acked"] <= after[f"{x}.acked"],
                geometry.noted[x]["granted"] >= after[f"{x}.granted"],
            ),
        )
        for x in "AB"
    }


def _goes_on(after: State, b: str, old: str) -> Iterator[Any]:
    for kept in ("number", "asked", "A.life", "B.life"):
        yield after[f"{b}.{kept}"] == S[f"{old}.{kept}"]
    for once in ("told", "A.dead", "B.dead"):
        now, before = after[f"{b}.{once}"], S[f"{old}.{once}"]
        yield z3.Or(now == before, z3.And(before == 0, now == after["v"]))
    for x, y in (("A", "B"), ("B", "A")):
        told = z3.Or(z3.And(after[f"{b}.told"] == 0, S[f"{old}.asked"] == CODE[x]), S[f"{old}.{y}.dead"] != 0)
        # What is behind the place that was told is behind the one that is in force.
        yield z3.Implies(told, z3.Implies(*[BESIDE[y](each[f"{y}.acked"], ANY_LINE) for each in (S, after)]))


def _settled(x: str, outcome: Outcome) -> None:
    outcome.terms.regions[x].append(NEXT)
    outcome.terms.lines.append(ANY_LINE)
    outcome.given(INSIDE[x](S[f"{x}.body"], NEXT))


def _fenced(x: str, outcome: Outcome) -> None:
    body = z3.Const(f"{x}.stands", BODY)  # with a part that it carries, or without one that it may carry
    there = S[f"{OTHER[x]}.phase"] == PRESENT
    outcome.stands_at(x, body, NEXT)
    outcome.given(
        z3.Or(body == S[f"{x}.body"], body == S[f"{x}.own"]),
        z3.Implies(z3.And(S[f"{x}.reach"], there), body == S[f"{x}.own"]),
        z3.Implies(z3.Not(S[f"{x}.still"]), INSIDE[x](body, NEXT)),  # the place that is told
    )


def _joined(x: str, outcome: Outcome) -> None:
    outcome.begins(x)
    outcome.after[f"{x}.own"] = outcome.after[f"{x}.body"]


def _announced(x: str, outcome: Outcome) -> None:
    body = z3.Const(f"{x}.announced", BODY)
    outcome.stands_at(x, body, NEXT)
    outcome.begins(x)
    outcome.given(INSIDE[x](body, NEXT))


def _granted(x: str, outcome: Outcome) -> None:
    """Numbers between the newest region and this one name no region of X, and are taken for empty ones."""
    outcome.terms.regions[x].append(NEXT)
    outcome.facts.append(
        lambda t: [
            z3.Implies(
                z3.And(S[f"{x}.granted"] < r, r < NEXT),
                z3.And(
                    *[_apart(x, r, other) for other in t.regions[OTHER[x]]],
                    *[BESIDE[x](r, line) for line in t.lines],
                ),
            )
            for r in t.regions[x]
        ]
    )


def _announce(made: Any, disk: Any) -> None:
    found = made.announce(disk.name, None)
    found.held.disk = NAMES[disk.name]


def _acknowledged(number: Number, made: Any, disk: Any, _: Any) -> None:
    made.acknowledge(disk, number)


def _elsewhere(made: Any) -> None:
    """A rule that concerns neither disk."""
    made.version = made.version + 1


def ledger_cases() -> Iterator[Case]:
    """Every rule of the ledger, of either disk."""
    for x in "AB":
        yield of_ledger("rejoin", lambda m, d, _: m.rejoin(d), x, _joined)
        yield of_ledger("fence", lambda m, d, _: m.fence(d, NEXT), x, _fenced)
        yield of_ledger("settle", lambda m, d, _: m.settle(d, NEXT), x, _settled)
        yield of_ledger("grant", lambda m, d, _: m.grant(d, NEXT), x, _granted)
        said = Number(S[f"{x}.said"])
        yield of_ledger("acknowledge", partial(_acknowledged, said), x)
        yield of_ledger("ask", lambda m, d, o: m.ask(d, o), x)
        yield of_ledger("announce", lambda m, d, _: _announce(m, d), x, _announced)
        yield of_ledger("appear", lambda m, d, _: m.appear([d]), x)
        yield of_ledger("appear instead", lambda m, d, o: m.appear([d], [o]), x)
        yield of_ledger("remove", lambda m, d, _: m.remove(d), x)
    yield of_ledger("introduce", lambda m, d, o: m.introduce(d, o, LINE_OF(NEXT, 0)), "A")
    yield of_ledger("part", lambda m, d, o: m.part(d, o), "A")
    yield of_ledger("elsewhere", lambda m, *_: _elsewhere(m), "A")
    for b, slot in (("L", "living"), ("S", "static")):
        yield _answer(b, slot)
    yield Case("begin", _begin, starts=True)
    yield Case("restart", _restart)


def _answer(b: str, slot: str) -> Case:
    def does(made: Any, *_: Any) -> None:
        made.answer(getattr(made.pairs[1][2], slot), LINE_OF(S[f"{b}.number"], 0))

    case = of_ledger(f"answer {b}", does, "A")
    case.rule, case.given = f"answer {b}", [S[f"{b}.on"], S[f"{b}.frozen"], S[f"{b}.asked"] != 0]
    return case


def _begin() -> Outcome:
    """The first ledger, of disks that are disjoint."""
    outcome = _restart()
    a, b = (outcome.after[f"{x}.body"] for x in "AB")
    outcome.facts = []
    outcome.given(EPOCH > 0, *[INSIDE[x](outcome.after[f"{x}.body"], EPOCH) for x in "AB"])
    outcome.given(DISJOINT(a, b))
    for x in "AB":
        outcome.after[f"{x}.said"] = z3.IntVal(0)
    return outcome


def _restart() -> Outcome:
    """Another coordinator begins: a new ledger of a new epoch, with disks where they stand."""
    made = ledger.Ledger(0, {1: None, 2: None}, Geometry())
    outcome = Outcome()
    after = outcome.after
    outcome.given(S["v"] < EPOCH)
    for x in "AB":
        disk = made.disks[CODE[x]]
        assert (disk.life, disk.still, made.pairs[1]) == (0, True, {})
        body = z3.Const(f"{x}.restarted", BODY)
        was_there = S[f"{x}.phase"] == PRESENT
        after[f"{x}.phase"] = z3.If(was_there, z3.IntVal(PRESENT), z3.IntVal(0))
        after[f"{x}.life"], after[f"{x}.still"] = z3.IntVal(disk.life), z3.BoolVal(disk.still)
        after[f"{x}.acked"] = after[f"{x}.granted"] = EPOCH
        outcome.begins(x)
        outcome.stands_at(x, body, EPOCH)
        outcome.given(INSIDE[x](body, EPOCH), body == real(S, x))
    after["v"] = EPOCH
    after["L.on"] = after["S.on"] = z3.BoolVal(False)
    return outcome


# -- rules of a robot


def of_bound(rule: str, b: str, x: str, does: Callable[[Any, Any], object], *given: Any) -> Case:
    """A rule of one end that was taken, be its life the present one or over."""

    def run() -> Outcome:
        geometry = Geometry()
        bound = bound_of(b, x)
        does(robot_of(x, geometry), bound)
        outcome = Outcome(geometry)
        bound_state(bound, outcome.after, b, x)
        return outcome

    return Case(f"{rule} {x} {b}", run, [S[f"{b}.on"], S[f"{b}.{x}.has"], *given])


def robot_cases() -> Iterator[Case]:
    """Every rule of a robot."""
    for b in "LS":
        yield from _line_cases(b)
        for x in "AB":
            freeze = of_bound("freeze", b, x, partial(_freeze, b))
            yield Case(freeze.rule, partial(_say, freeze.run, b), freeze.given)
    for x in "AB":
        # An end of a living binding is never told that the other stands for good.
        yield of_bound("turn", "S", x, lambda made, bound: made.turn(bound, HALF_PLANE))
        alive = [S[f"{x}.life"] != 0, S[f"{x}.phase"] == PRESENT]  # the base obeys the present life only
        yield Case(f"adopt region {x}", partial(_adopt, x), alive)
        yield Case(f"say region {x}", partial(_acknowledge, x), alive)
        yield Case(f"hear {x}", partial(_hear, x, ""), _heard(x))
        yield Case(f"hear {x} late", partial(_hear, x, "S"), _heard_late(x))
        yield Case(f"command {x}", partial(_command, x), alive)
        yield Case(f"locate {x}", partial(_locate, x), alive)


HALF_PLANE, PROPOSED = z3.Const("half", LINE), z3.Int("proposed")


def _line(b: str, number: Any) -> Any:
    return LINE_OF(S[f"{b}.number"], number)


def _line_cases(b: str) -> Iterator[Case]:
    """Rules of the line of a binding; answers arrive late, repeated or never."""
    line = _line(b, S[f"{b}.A.number"] + 1)
    yield of_bound("propose", b, "A", lambda m, bound: _lines(bound).propose(line, m.fits(bound, line)))
    proposed = _line(b, PROPOSED)

    def adopt(made: Any, bound: Any) -> None:
        _lines(bound).on_proposal(Number(PROPOSED), proposed, made.fits(bound, proposed))

    yield of_bound("adopt", b, "B", adopt, PROPOSED >= 1, ends(S, b)["number"] >= PROPOSED)
    answer = Number(S[f"{b}.h2"]), Number(S[f"{b}.s2"])
    yield of_bound("read answer", b, "A", lambda _, bound: _lines(bound).on_answer(*answer))
    yield Case(f"send answer {b}", lambda: _send(b), [S[f"{b}.on"], S[f"{b}.B.has"]])


def _lines(bound: Any) -> Any:
    if bound.lines is None:
        raise symbolic.Impossible
    return bound.lines


def _send(b: str) -> Outcome:
    outcome = Outcome()
    for h, s, sent in (("h", "s", "first"), ("h2", "s2", "second")):
        sends = z3.And(z3.Bool(sent), S[f"{b}.B.state"] != ASKED)
        outcome.after[f"{b}.{h}"] = z3.If(sends, S[f"{b}.B.held"], S[f"{b}.{h}"])
        outcome.after[f"{b}.{s}"] = z3.If(sends, S[f"{b}.B.seen"], S[f"{b}.{s}"])
    return outcome


def _freeze(b: str, made: Any, bound: Any) -> None:
    made.freeze(bound, _line(b, 0))


def _say(run: Callable[[], Outcome], b: str) -> Outcome:
    """A first line is said to the ledger."""
    outcome = run()
    outcome.after[f"{b}.frozen"] = z3.BoolVal(True)
    return outcome


def _adopt(x: str) -> Outcome:
    geometry = Geometry()
    made = robot_of(x, geometry)
    made.adopt()
    outcome = Outcome(geometry)
    outcome.after[f"{x}.obeyed"] = expression(made.number)
    return outcome


def _acknowledge(x: str) -> Outcome:
    """The present life says which region it obeys."""
    outcome = Outcome()
    outcome.after[f"{x}.said"] = z3.If(S[f"{x}.obeyed"] != 0, S[f"{x}.obeyed"], S[f"{x}.said"])
    return outcome


AT, NUMBER = z3.Int("heard"), z3.Int("heard region")
LIFE, TO = z3.Int("hearing life"), z3.Int("life told")


def _heard(x: str) -> list[Any]:
    """A Tick of any version arrives at the present life."""
    present = [S[f"{x}.life"] == LIFE, LIFE != 0, S[f"{x}.phase"] == PRESENT]
    told = [S["v"] >= AT, AT > TO, NUMBER <= AT]
    return [*present, *told, z3.Implies(LIFE == TO, S[f"{x}.granted"] >= NUMBER)]


def _heard_late(x: str) -> list[Any]:
    """One arrives at a life that is over; what is told to that life was told before."""
    over = [S["S.on"], S[f"S.{x}.life"] == LIFE, LIFE != 0, S[f"S.{x}.dead"] != 0]
    return [*over, z3.Implies(LIFE == TO, S[f"S.{x}.dead"] > AT)]


def is_listed(b: str, x: str) -> Any:
    """Whether a binding in force is listed in a Tick to the life of its end at X."""
    told = z3.And(S[f"{b}.told"] != 0, S[f"{b}.told"] <= AT)
    return z3.And(S[f"{b}.number"] <= AT, z3.Or(told, S[f"{b}.asked"] == CODE[x]))


def listing(b: str, x: str) -> Any:
    """A binding as a Tick tells it."""
    y = OTHER[x]
    told = bool(Truth(z3.And(S[f"{b}.told"] != 0, S[f"{b}.told"] <= AT)))
    static = Truth(z3.And(S[f"{b}.{y}.dead"] != 0, S[f"{b}.{y}.dead"] <= AT))
    first = _line(b, 0) if told else None
    return records.Listed(Number(S[f"{b}.number"]), CODE[y], first, S[f"{y}.acked"], static)


def _hear(x: str, late: str) -> Outcome:
    """A Tick is heard, of which every binding in force is told as it was at its version (`history`)."""
    geometry = Geometry()
    ends_of = {
        life: [b for b in "LS" if Truth(z3.And(S[f"{b}.on"], S[f"{b}.{x}.life"] == life))]
        for life in (LIFE, TO)
    }
    bounds = [bound_of(b, x, lines=False) for b in ends_of[LIFE] if Truth(S[f"{b}.{x}.has"])]
    made = robot_of(x, geometry, bounds)
    made.life = Number(LIFE)
    if late:
        made.version = Number(S[f"{late}.{x}.taken"])
    listed = [listing(b, x) for b in ends_of[TO] if Truth(is_listed(b, x))]
    made.hear(records.Told(Number(TO), Number(AT), Number(NUMBER), NUMBER, listed))
    outcome = Outcome(geometry)
    after = outcome.after
    if late:
        after[f"{late}.{x}.taken"] = expression(made.version)
    else:
        after[f"{x}.taken"], after[f"{x}.offered"] = expression(made.version), expression(made.offered_number)
    for b in ends_of[LIFE]:
        after[f"{b}.{x}.has"] = z3.BoolVal(False)
        for bound in made.bound.values():
            if bound.number == Number(S[f"{b}.number"]):
                bound_state(bound, after, b, x)
    return outcome


def told_now(x: str) -> Outcome:
    """What the ledger tells a life of X now is what the rule of hearing takes it for, at this version."""
    made = ledger_of(Geometry())
    told, outcome = made.told(made.disks[CODE[x]]), Outcome()
    outcome.given(S["v"] == AT, S[f"{x}.life"] == LIFE, LIFE != 0)
    claims = {
        "life": expression(told.life) == LIFE,
        "version": expression(told.version) == AT,
        "region": expression(told.number) == S[f"{x}.granted"],
    }
    for b, slot in (("L", "living"), ("S", "static")):
        both = made.pairs[1].get(2)
        if both is None or getattr(both, slot) is None:
            continue
        listed = [each for each in told.bindings if each.number.of.eq(S[f"{b}.number"])]
        claims[f"{b} is listed"] = z3.BoolVal(bool(listed)) == z3.And(
            S[f"{b}.{x}.life"] == LIFE, is_listed(b, x)
        )
        for each in listed:
            should = listing(b, x)
            claims[f"{b} is static"] = expression(each.static) == expression(should.static)
            place = S[f"{OTHER[x]}.still"] if each.place is not None else z3.Not(S[f"{OTHER[x]}.still"])
            claims[f"{b} says where the other end stands"] = place
    outcome.claims = {f"told: {name}": claim for name, claim in claims.items()}
    return outcome


def _command(x: str) -> Outcome:
    body, own = z3.Const("next body", BODY), z3.Const("next own", BODY)
    geometry = Geometry()
    mine = [b for b in "LS" if Truth(z3.And(S[f"{b}.on"], S[f"{b}.{x}.has"], S[f"{b}.{x}.dead"] == 0))]
    made = robot_of(x, geometry, [bound_of(b, x, lines=False) for b in mine])
    if Truth(S[f"{x}.obeyed"] != 0):
        made.region = S[f"{x}.obeyed"]
    made.command(body, own, Number(PART))
    outcome = Outcome(geometry)
    outcome.after[f"{x}.body"], outcome.after[f"{x}.own"] = made.body, made.own
    outcome.after[f"{x}.reach"] = expression(made.part) == CODE[OTHER[x]]
    outcome.covers_less(x, own, body)
    return outcome


def _locate(x: str) -> Outcome:
    """The body covers less than before: a command has no more effect, or the estimate is better."""
    outcome, made = Outcome(), robot_of(x, Geometry())
    body, own = z3.Const(f"{x}.less body", BODY), z3.Const(f"{x}.less own", BODY)
    made.locate(body, own)
    outcome.after[f"{x}.body"], outcome.after[f"{x}.own"] = made.body, made.own
    for less, more in ((body, S[f"{x}.body"]), (own, S[f"{x}.own"]), (own, body)):
        outcome.covers_less(x, less, more)
    return outcome


def cases() -> Iterator[Case]:
    """Every rule."""
    yield from ledger_cases()
    yield from robot_cases()
    for x in "AB":
        yield Case(f"tell {x}", partial(told_now, x))
