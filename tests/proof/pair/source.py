"""The product's source of a pair, read by the solver, does what the rules of the model do, and nothing else.

Each method is run on symbols in every way through it. Whatever came out, one of the rules that stand for it
was possible and has the same outcome, or none was possible and nothing has changed. Of the state before,
conjuncts of the proved invariant are assumed; of the arguments, needs of rules, by name: those that the
network, the rest of the robot or geometry answer for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from types import ModuleType, SimpleNamespace
from typing import Any

import z3

from tests.interpreted import Edit, interpreted
from tests.proof.engine.logic import INT, Term, every, implies, no, pick, some
from tests.proof.engine.paths import Symbol, Truth, decide, term_of, ways
from tests.proof.engine.state import State, Symbolic
from tests.proof.engine.system import needs_of
from tests.proof.pair.invariant import PAIR
from tests.proof.pair.model import (
    DISK,
    FOLLOWER,
    LINE,
    OWNER,
    SCHEMA,
    STATIC,
    acts,
    agreed,
    apart,
    begin_founding,
    begin_life,
    fits,
    held_line,
    left,
    obeys,
    ready,
    right,
)

ENDS, PAIR_OF_ONE, KNOWN, ROSTER, NEAR, TANGENT, LEDGER = MODULES = (
    *("agents.lines.ends", "agents.lines.robot_pair", "agents.peers.roster", "world.coordinator.roster"),
    *("agents.lines.negotiation.near", "agents.lines.tangent", "agents.lines.separating_lines"),
)
_READ_BY = {  # which calls come through a module
    ENDS: ("Owner", "Follower", "RobotPair"),
    **{PAIR_OF_ONE: ("RobotPair",), KNOWN: ("KnownRoster",), ROSTER: ("Roster",), NEAR: ("NearNegotiation",)},
    **{TANGENT: ("Tangent",), LEDGER: ("SeparatingLines",)},
}
WORDS = ("gone", "appearing", "standing", "live")  # what the roster calls the statuses of the model
A, K, LIFE, V, MINE, HELD, SEEN = z3.Ints("a k life v mine held seen")  # any lives, versions and numbers
SPOT, RESIZED = z3.Consts("spot resized", DISK.z3)  # a place that is stated; the same with another radius
FOUNDING, FITTING = z3.Int("founding"), z3.Bool("fitting")  # the peer's founding life; whether a line fits
OFFERED = z3.Const("offered", LINE.z3)
_STATE = Symbolic(SCHEMA)  # any
RADIUS, BOUND, TICK = Symbol(z3.Int("radius")), Symbol(z3.Int("bound")), Symbol(z3.Int("tick"))

Outcome = list[
    tuple[Callable[[State], Term], Term]
]  # what a rule makes of something, and what the method did
Ways = Sequence[
    Sequence[tuple[str, tuple[Term, ...]]]
]  # rules in turn, with arguments; each for one way to go


@dataclass(frozen=True)
class Case:
    """One call of a method on symbols.

    Attributes:
        name: of it.
        run: calls it in a state; what came out.
        rules: that stand for it.
        answered: names of their needs that others answer for.
        when: what its caller makes sure of, in a state.
        around: lives, versions and numbers of which the invariant is taken to speak.
        may_refuse: whether nothing may happen although a rule is possible.
        begin: makes the state before the rules of any; that itself, unless given.
    """

    name: str
    run: Callable[[Symbolic], Outcome]
    rules: Ways
    answered: tuple[str, ...] = ()
    when: Callable[[Symbolic], Term] = lambda _: z3.BoolVal(True)
    around: tuple[Term, ...] = (A,)
    may_refuse: bool = False
    begin: Callable[[Symbolic], Symbolic] = lambda s: s


def deviations(case: Case) -> Iterator[str]:
    """What the source does and no rule does, for each way through it; at the end, how many ways there are."""
    s = _STATE
    ends: list[tuple[Term, Symbolic]] = []
    known = [case.when(s)]
    for rules in case.rules:
        n, needs = case.begin(s), []
        for name, args in rules:
            before, n = n, n.after()
            needs += needs_of(PAIR.rules[name], before, n, args)
        known += [condition for name, condition in needs if name in case.answered]
        ends.append(
            (every(z3.BoolVal(True), *[each for name, each in needs if name not in case.answered]), n)
        )
    solver, s = z3.SimpleSolver(), case.begin(s)
    solver.set("timeout", 5_000)
    solver.add(*known, *_invariant(case.around))
    for told, outcome in ways(lambda: case.run(s), known):
        goals = [every(possible, *_same(outcome, n)) for possible, n in ends]
        if case.may_refuse:
            goals.append(every(*_same(outcome, s)))
        else:
            goals.append(every(*_same(outcome, s), *[no(possible) for possible, _ in ends]))
        as_a_rule = solver.check(*told, z3.Not(some(*goals))) == z3.unsat
        yield "" if as_a_rule else f"{case.name}, where {told}"


def _same(outcome: Outcome, n: Symbolic) -> list[Term]:
    return [read(n) == value for read, value in outcome]


@cache
def _invariant(around: tuple[Term, ...]) -> list[Term]:
    """What the invariant says of the state, its scalars and what is spoken of."""
    s = _STATE
    values = [*around, s.o.life, s.f.life, s.version]
    return [
        conjunct.run(s, *point)
        for conjunct in PAIR.conjuncts.values()
        if len(conjunct.parameters) <= 2 and set(conjunct.parameters.values()) <= {INT}
        for point in product(values, repeat=len(conjunct.parameters))
    ]


# -- what a method finds: symbols in place of lines, numbers and messages


class Lines:
    """Some lines of an owner's life, by their numbers; or one, of which the individual is known, too."""

    nx = ny = limit = offset = 0.0
    gap = staticmethod(lambda *_: 0.0)

    def __init__(self, has: Callable[[Term], Term], one: Term = None) -> None:
        self.has, self.one = has, one

    def side(self, radius: float, owner: bool) -> Lines:
        """The half-planes that they leave."""
        return self


class Offers:
    """Proposals by number, as a dictionary: of all that are there, any one."""

    def __init__(self, s: State) -> None:
        self.state, self.added = s, list[tuple[Term, Term]]()

    def has(self, k: Term) -> Term:
        return some(self.state.o.proposed[A, k], *[k == key for key, _ in self.added])

    def line(self, k: Term) -> Term:
        term = self.state.o.line[A, k]
        for key, line in self.added:
            term = pick(k == key, line, term)
        return term

    def __contains__(self, key: Symbol) -> bool:
        return decide(self.has(term_of(key)))

    def __getitem__(self, key: Symbol) -> Lines:
        k = term_of(key)
        return Lines(lambda other: other == k, self.line(k))

    def __setitem__(self, key: Symbol, line: Lines) -> None:
        self.added.append((key.term, line.one))

    def __bool__(self) -> bool:
        return decide(z3.Bool("anything proposed"))

    def __len__(self) -> int:
        return 0  # as many as there may be: it only keeps them from becoming too many

    def values(self) -> list[Lines]:
        return [Lines(self.has)]

    def items(self) -> Iterator[tuple[Symbol, Lines]]:
        if decide(self.has(K)):
            yield Symbol(K), Lines(lambda k: k == K, self.line(K))


def _has(offers: Any, k: Term) -> Term:
    """Whether a number is among what is offered, when a method has ended."""
    return offers.has(k) if isinstance(offers, Offers) else some(False, *[k == key.term for key in offers])


def _end(s: State, ends: ModuleType, r: str) -> Any:
    """One end of a line, as it may be."""
    me = s[r].at(A)
    end = (ends.Owner if r == OWNER else ends.Follower).__new__(ends.Owner if r == OWNER else ends.Follower)
    end.incarnation, end.peer_incarnation = Symbol(A), Symbol(me.peer)
    end.held_number, end.seen = Symbol(me.held), Symbol(me.seen)
    if r == OWNER:
        end.number, end.met, end.agreed = Symbol(me.number), Truth(me.met), Truth(me.agreed)
        end.proposed, end._inherited = Offers(s), (Lines(lambda k: s.o.inherited[A, k]),)
        held = Lines(lambda k: k == me.held, s.o.line[A, me.held])
        end.held = held if decide(me.holds) else None
    else:
        end.linked = Truth(me.linked)
        end._held = Lines(lambda _: z3.BoolVal(False), held_line(s, A)) if decide(me.holds) else None
    return end


def _of_end(r: str, end: Any) -> Outcome:
    """What an end is now."""
    here = lambda name: lambda n: getattr(n[r].at(A), name)  # noqa: E731
    held = end.held if r == OWNER else end._held
    line = (lambda n: n.o.line[A, n.o.held[A]]) if r == OWNER else (lambda n: held_line(n, A))
    found: Outcome = [
        (here("peer"), term_of(end.peer_incarnation)),
        (here("held"), term_of(end.held_number)),
        (here("seen"), term_of(end.seen)),
        (here("holds"), z3.BoolVal(held is not None)),
        (lambda n: True if held is None else line(n) == held.one, z3.BoolVal(True)),
    ]
    if r == FOLLOWER:
        return [*found, (here("linked"), _bool(end.linked))]
    offered = [*end.proposed.added] if isinstance(end.proposed, Offers) else []
    return [
        *found,
        (here("number"), term_of(end.number)),
        (here("met"), _bool(end.met)),
        (here("agreed"), _bool(end.agreed)),
        (lambda n: n.o.proposed[A, K], _has(end.proposed, K)),
        (lambda n: n.o.inherited[A, K], some(z3.BoolVal(False), *[each.has(K) for each in end._inherited])),
        *[(lambda n, key=key: n.o.line[A, key], line) for key, line in offered],
    ]


def _bool(value: Any) -> Term:
    term = term_of(value)
    return z3.BoolVal(term) if isinstance(term, bool) else term


def _pair(s: State, modules: Sequence[ModuleType], r: str) -> Any:
    """One robot's side of a pair, as it may be."""
    me, robot_pair = s[r].at(A), modules[1]
    pair = robot_pair.RobotPair.__new__(robot_pair.RobotPair)
    pair.owns, pair.settled, pair.rests, pair.peer = r == OWNER, False, False, 2
    pair.own_radius, pair.radius, pair.answers_left, pair.transit = 1.0, 1.0, 0, 0
    pair.end = _end(s, modules[0], r)
    pair.heard, pair.excused = Symbol(me.heard), Truth(me.excused)
    pair.state = (
        SimpleNamespace(incarnation=Symbol(me.peer), tick=TICK, placed=False) if decide(me.talks) else None
    )
    pair.line_half_planes = pair.end.obeyed
    pair.disk = None
    if decide(me.stands):
        pair.disk = SimpleNamespace(
            spot=me.spot, half_plane=Lines(lambda _: False) if decide(me.clear) else None
        )
    return pair


def _of_pair(r: str, pair: Any) -> Outcome:
    """What that side is now. What it keeps at hand of its end is what its end says."""
    here = lambda name: lambda n: getattr(n[r].at(A), name)  # noqa: E731
    state, disk, planes = pair.state, pair.disk, pair.line_half_planes
    clear = disk is not None and disk.half_plane is not None
    obeyed = (
        (lambda n: obeys(n, A, K) == some(z3.BoolVal(False), *[each.has(K) for each in planes]))
        if r == OWNER
        else (lambda n: n.f.holds[A] == (len(planes) == 1 and planes[0].one is not None))
    )
    return [
        *_of_end(r, pair.end),
        (here("heard"), term_of(pair.heard)),
        (here("excused"), _bool(pair.excused)),
        (here("talks"), z3.BoolVal(state is not None)),
        (lambda n: True if state is None else n[r].peer[A] == state.incarnation.term, z3.BoolVal(True)),
        (here("stands"), z3.BoolVal(disk is not None)),
        (lambda n: implies(n[r].stands[A], n[r].clear[A]), z3.BoolVal(disk is None or clear)),
        (lambda n: True if disk is None else n[r].spot[A] == disk.spot, z3.BoolVal(True)),
        (obeyed, z3.BoolVal(True)),
        (lambda n: implies(_bool(pair.settled), agreed(n, r, A)), z3.BoolVal(True)),
        (
            lambda n: implies(_bool(pair.settled), no(every(n.o.inherited[A, K], r == OWNER))),
            z3.BoolVal(True),
        ),
    ]


# -- the methods


def cases(edits: Sequence[Edit] = ()) -> list[Case]:
    """All calls that stand for rules.

    Args:
        edits: what reads otherwise than in the sources.
    """
    modules = interpreted(*MODULES, edits=edits)
    read_by = tuple(prefix for edit in edits for prefix in _READ_BY[edit.module]) or ("",)
    found = [*_of_the_line(modules[0]), *_of_the_coordinator(modules[3]), _of_an_offer(modules)]
    for r, q in ((OWNER, FOLLOWER), (FOLLOWER, OWNER)):
        found += [*_of_a_pair(modules, r, q), *_of_a_roster(modules[2], r, q), *_of_a_robot(modules, r, q)]
    return [case for case in found if case.name.startswith(read_by)]


def _of_the_line(ends: ModuleType) -> Iterator[Case]:
    def propose(s: Symbolic) -> Outcome:
        end = _end(s, ends, OWNER)
        number = end.propose(Lines(lambda _: False, OFFERED))
        return [*_of_end(OWNER, end), (lambda n: n.o.number[A], term_of(number))]

    needs = "only to a life that was heard", "only what the own disk satisfies"
    yield Case("Owner.propose", propose, [[("propose", (A, OFFERED))]], needs)

    def on_answer(mine: Term) -> Callable[[Symbolic], Outcome]:
        def run(s: Symbolic) -> Outcome:
            end = _end(s, ends, OWNER)
            end.on_answer(Symbol(s.o.peer[A]), Symbol(mine), Symbol(HELD), Symbol(SEEN))
            return _of_end(OWNER, end)

        return run

    heard = "a State of that life is at hand", "older lives are ignored", "the answer was given, to this life"
    answer = (A, LIFE, HELD, SEEN)
    learned = [[("learn_what_was_adopted", answer)], [("learn_what_was_rejected", answer)]]
    yield Case("Owner.on_answer", on_answer(A), learned, heard, around=(A, LIFE))
    yield Case(
        "Owner.on_answer to another life",
        on_answer(MINE),
        [],
        when=lambda s: every(acts(s, OWNER, A), s.o.talks[A], MINE != A),
    )

    def on_proposal(mine: Term) -> Callable[[Symbolic], Outcome]:
        def run(s: Symbolic) -> Outcome:
            end, line = _end(s, ends, FOLLOWER), s.o.line[LIFE, K]
            peer, fits = Symbol(s.f.peer[A]), Truth(right(s.f.ground[A], line))
            end.on_proposal(peer, Symbol(mine), Symbol(K), Lines(lambda _: False, line), lambda _: fits)
            return _of_end(FOLLOWER, end)

        return run

    heard = (
        "a State of that life is at hand",
        "older lives are ignored",
        "the proposal was made",
        "it is for this life",
    )
    offered = [[("adopt", (A, LIFE, K))], [("reject", (A, LIFE, K))]]
    yield Case("Follower.on_proposal", on_proposal(A), offered, heard, around=(A, LIFE))
    yield Case(
        "Follower.on_proposal to another life",
        on_proposal(MINE),
        [],
        when=lambda s: every(acts(s, FOLLOWER, A), s.f.talks[A], MINE != A),
    )


def _of_a_pair(modules: Sequence[ModuleType], r: str, q: str) -> Iterator[Case]:
    robot_pair: Any = modules[1]

    def accept(s: Symbolic) -> Outcome:
        pair = _pair(s, modules, r)
        taken = pair.accept(
            SimpleNamespace(incarnation=Symbol(LIFE), tick=Symbol(TICK.term + 1), placed=False)
        )
        return [*_of_pair(r, pair), (lambda _: s[r].peer[A] <= LIFE, _bool(taken))]

    speaks = [[(f"{name} ({r})", (A, LIFE))] for name in ("hear_it_speak", "hear_a_new_life_speak")]
    needs = "it has heard a roster", "that life has begun"
    yield Case(f"RobotPair.accept ({r})", accept, speaks, needs, around=(A, LIFE, K))

    def on_member(s: Symbolic) -> Outcome:
        pair, says = _pair(s, modules, r), s[q]
        robot_pair.Disk = lambda *disk: pick(
            disk[2].term == RADIUS.term + BOUND.term, says.was_place[V], RESIZED
        )
        robot_pair.Tangent = lambda spot, *_: SimpleNamespace(spot=spot, half_plane=None)
        status = Symbol(says.was_status[V], WORDS)
        pair.on_member(
            SimpleNamespace(
                incarnation=Symbol(says.was_life[V]),
                status=status,
                position=(0, 0),
                radius=RADIUS,
                bound=BOUND,
            )
        )
        return _of_pair(r, pair)

    names = "too_late", "that_it_lives", "of_a_new_life", "of_a_place", "that_it_is_gone"
    hears = [[(f"hear_{name} ({r})", (A, V))] for name in names]
    needs = "the life has begun", "a version is told while it is the newest", "older versions are ignored"
    yield Case(f"RobotPair.on_member ({r})", on_member, hears, needs, around=(A, V, K))

    def is_ready(s: Symbolic) -> Outcome:
        return [(lambda _: ready(s, r, A), _bool(_pair(s, modules, r).ready))]

    yield Case(f"RobotPair.ready ({r})", is_ready, [], when=lambda s: acts(s, r, A))


def _of_an_offer(modules: Sequence[Any]) -> Case:
    near = modules[4]

    def consider(s: Symbolic) -> Outcome:
        pair, negotiation = _pair(s, modules, OWNER), near.NearNegotiation(1.0, 1.0)
        vars(near)["is_same"] = lambda *_: False
        negotiation._fit_line = lambda *_: Lines(lambda _: False, OFFERED)
        if pair.state is not None:
            pair.state = SimpleNamespace(
                incarnation=pair.state.incarnation, placed=True, tick=0, x=0.0, y=0.0, bound=0.0
            )
        me, fits = SimpleNamespace(x=0.0, y=0.0, radius=1.0), Truth(left(s.o.ground[A], OFFERED))
        negotiation._consider(0, pair, me, lambda _: fits, False, 1)
        return _of_pair(OWNER, pair)

    offers = [[("propose", (A, OFFERED))]]
    heard = lambda s: acts(s, OWNER, A)  # noqa: E731
    return Case("NearNegotiation._consider", consider, offers, when=heard, around=(A, K), may_refuse=True)


def _of_a_robot(modules: Sequence[Any], r: str, q: str) -> Iterator[Case]:  # noqa: C901
    """What a robot asks of all its pairs, for one of them; and the half-plane that it turns."""

    def lines(s: Symbolic) -> Any:
        ledger, pair = modules[6].SeparatingLines.__new__(modules[6].SeparatingLines), _pair(s, modules, r)
        ledger._each, ledger._disturbed = [pair], True
        return ledger

    def is_ready(s: Symbolic) -> Outcome:
        return [(lambda _: ready(s, r, A), _bool(lines(s).ready))]

    def keeps_clear(s: Symbolic) -> Outcome:
        me = s[r].at(A)
        return [(lambda _: implies(every(me.excused, me.stands), me.clear), _bool(lines(s).keeps_clear))]

    def renew(s: Symbolic) -> Outcome:
        me = s[r].at(A)
        before = Lines(lambda _: False, me.tangent) if decide(me.clear) else None
        tangent = modules[5].Tangent.__new__(modules[5].Tangent)
        around = SimpleNamespace(x=3.0, y=4.0, radius=1.0, limit=lambda *_: 1.0)
        tangent.shape = tangent._around = around
        tangent.radius, tangent.half_plane = 1.0, before
        modules[5].HalfPlane = lambda *_: Lines(lambda _: False, OFFERED)
        fits_now = Truth(fits(r, s[r].ground[A], OFFERED))
        tangent.renew(SimpleNamespace(x=0.0, y=0.0, bound=0.0, satisfies=lambda _: fits_now))
        after = tangent.half_plane
        return [
            (lambda n: n[r].clear[A], z3.BoolVal(after is not None)),
            (lambda n: True if after is None else n[r].tangent[A] == after.one, z3.BoolVal(True)),
        ]

    def life(founding: bool) -> Callable[[Symbolic], Symbolic]:
        def begin(s: Symbolic) -> Symbolic:
            n = s.after()
            begin_life(n, r, A)
            if founding:
                begin_founding(n, r, A, FOUNDING, FITTING)
            return n

        return begin

    def first(founding: bool) -> Callable[[Symbolic], Outcome]:
        def run(s: Symbolic) -> Outcome:
            ledger, says = modules[6], s[q]
            one = s.o.line[A if r == OWNER else FOUNDING, 0]
            ledger.initial_line = lambda *_: Lines(lambda k: k == 0, one) if decide(FITTING) else None
            modules[1].Disk = lambda *_: says.was_place[V]
            modules[1].Tangent = lambda spot, *_: SimpleNamespace(
                spot=spot, half_plane=None, renew=lambda *_: None
            )
            me, peer = (1, 2) if r == OWNER else (2, 1)
            life, status = Symbol(says.was_life[V]), Symbol(says.was_status[V], WORDS)
            told = _Entry(peer, life, status, RADIUS, (0, 0), BOUND, Symbol(FOUNDING))
            lines = ledger.SeparatingLines(
                me,
                Symbol(A),
                {1: 1.0, 2: 1.0},
                speed=1.0,
                period=1.0,
                members={peer: told},
                starts={1: (0.0, 0.0), 2: (9.0, 0.0)} if founding else None,
            )
            return _of_pair(r, lines._pairs[peer])

        return run

    def begin(_: Symbolic) -> Outcome:
        behind = z3.Int("how far the place is behind a line")
        place = SimpleNamespace(around=None, limit=lambda *_: Symbol(behind))
        tangent = modules[5].Tangent(place, 1.0, [Lines(lambda _: False)])
        return [(lambda _: behind >= 0, z3.BoolVal(tangent.half_plane is not None))]

    names = "that_it_lives", "of_a_new_life", "of_a_place", "that_it_is_gone"
    hears = [[(f"hear_{name} ({r})", (A, V))] for name in names]
    needs = "the life has begun", "a version is told while it is the newest", "older versions are ignored"
    for founding in (False, True):
        begun = lambda s: every(  # noqa: E731
            s[r].born[A] > 0, FOUNDING >= 0, s[q].was_life[V] >= FOUNDING
        )
        name = f"SeparatingLines of a {'founding ' * founding}life ({r})"
        yield Case(name, first(founding), hears, needs, begun, (A, V, K), begin=life(founding))
    heard = lambda s: acts(s, r, A)  # noqa: E731
    yield Case(f"Tangent ({r})", begin, [])
    yield Case(f"SeparatingLines.ready ({r})", is_ready, [], when=heard)
    yield Case(f"SeparatingLines.keeps_clear ({r})", keeps_clear, [], when=heard)
    behind = "there is a place", "only with the place behind it"
    yield Case(f"Tangent.renew ({r})", renew, [[(f"turn ({r})", (A, OFFERED))]], behind)


def _of_a_roster(peers: ModuleType, r: str, q: str) -> Iterator[Case]:
    def update(s: Symbolic) -> Outcome:
        vars(peers)["_by_id"] = lambda members: {each.robot: each for each in members}
        me, known = peers.KnownRoster(1, Symbol(A)), s[r].known[A]
        changed = Truth(no(every(*_is_same(s, q, V, known))))
        before = SimpleNamespace(robot=2)
        now = _Member(2, changed)
        me.version, me.members = Symbol(known), {2: before} if decide(known > 0) else {}
        news = me.update(
            SimpleNamespace(version=Symbol(V), members=(_Member(1, True), now), things=(), parts=())
        )
        told = every(known < V, some(known == 0, changed.term))
        return [
            (lambda _: pick(known < V, V, known), term_of(me.version)),
            (lambda _: told, z3.BoolVal(any(each is now for each in news))),
            (lambda _: known < V, z3.BoolVal(me.members.get(2) is now)),
        ]

    yield Case(f"KnownRoster.update ({r})", update, [], when=lambda s: every(s[r].known[A] >= 0, V > 0))

    def founding(_: Symbolic) -> Outcome:
        me, life = peers.KnownRoster(1, Symbol(A)), Symbol(LIFE)
        me.members = {1: SimpleNamespace(founding=life)}
        return [(lambda _: every(A == LIFE, A > 0), _bool(me.founding))]

    yield Case(f"KnownRoster.founding ({r})", founding, [])


class _Member:
    """A member of a roster, of which it is known whether it is another than before."""

    def __init__(self, robot: int, changed: Any) -> None:
        self.robot, self._changed = robot, changed

    def __eq__(self, other: object) -> Any:
        return not self._changed

    def __ne__(self, other: object) -> Any:
        return True if other is None else self._changed

    __hash__ = None  # type: ignore[assignment]


def _is_same(s: State, q: str, v: Term, w: Term) -> list[Term]:
    says = s[q]
    return [
        getattr(says, name)[v] == getattr(says, name)[w] for name in ("was_life", "was_status", "was_place")
    ]


@dataclass(frozen=True)
class _Entry:
    """A member of the coordinator's roster. A place is where it is with this radius and this bound."""

    robot: int
    incarnation: Any
    status: Any
    radius: Any = RADIUS
    position: Any = None
    bound: Any = BOUND
    founding: Any = 0

    @property
    def place(self) -> Term:
        if self.position is None:
            return None
        as_stated = self.radius is RADIUS and self.bound is BOUND and isinstance(self.position, z3.ExprRef)
        return self.position if as_stated else RESIZED


def _of_the_coordinator(rosters: Any) -> Iterator[Case]:  # noqa: C901
    ids = {1: OWNER, 2: FOLLOWER}

    def roster(s: Symbolic) -> Any:
        rosters.replace, rosters.Member = replace, _Entry
        rosters._apart = lambda *_: Truth(apart(s.o.place, s.f.place))
        found = rosters.Roster(Symbol(s.version))
        for robot, r in ids.items():
            me = s[r]
            founding = Symbol(z3.Int(f"founding of {r}"))
            found._members[robot] = _Entry(
                robot, Symbol(me.life), Symbol(me.status, WORDS), RADIUS, me.place, BOUND, founding
            )
            found._kept[robot] = (Symbol(me.kept_life), Symbol(me.kept))
        return found

    def outcome(found: Any, *, begins: bool = False) -> Outcome:
        values: Outcome = [(lambda n: n.version, term_of(found.version))]
        for robot, r in ids.items():
            entry = found._members[robot]
            status, place, founding = term_of(entry.status, WORDS), entry.place, term_of(entry.founding)
            there = some(status == STATIC, status == STATIC - 1)
            first = lambda n, r=r: n[r].life if begins else z3.Int(f"founding of {r}")  # noqa: E731
            values += [
                (lambda n, r=r: n[r].life, term_of(entry.incarnation)),
                (lambda n, r=r: n[r].status, status),
                (
                    lambda n, r=r, place=place, there=there: implies(
                        there, False if place is None else n[r].place == place
                    ),
                    z3.BoolVal(True),
                ),
                (
                    lambda n, first=first, founding=founding: some(founding == 0, founding == first(n)),
                    z3.BoolVal(True),
                ),
            ]
            if not begins:
                life, version = found._kept[robot]
                values += [
                    (lambda n, r=r: n[r].kept_life, term_of(life)),
                    (lambda n, r=r: n[r].kept, term_of(version)),
                ]
        return values

    def call(act: Callable[[Any, Symbolic], object]) -> Callable[[Symbolic], Outcome]:
        def run(s: Symbolic) -> Outcome:
            found = roster(s)
            try:
                act(found, s)
            except rosters.RosterError:
                return outcome(roster(s))
            return outcome(found)

        return run

    def of_robot(robot: int, r: str) -> Iterator[Case]:
        true, keeps = "what is said of the place is true", "only of a life that is not over"
        larger = "only the disk that the robot keeps to all lines"
        calls: list[
            tuple[Callable[[Any, Symbolic], object], dict[str, tuple[Term, ...]], tuple[str, ...]]
        ] = [
            (lambda found, _: found.admit(robot, Symbol(LIFE)), {"admit": (LIFE,)}, ()),
            (lambda found, _: found.fence(robot, SPOT, BOUND), {"fence": (SPOT,)}, (true,)),
            (lambda found, _: found.announce(robot, RADIUS, SPOT, BOUND), {"announce": (SPOT,)}, ()),
            (lambda found, _: found.withdraw(robot), {"withdraw": ()}, ()),
            (lambda found, _: found.remove(robot), {"remove": ()}, ()),
            (
                lambda found, _: found.resize(robot, Symbol(z3.Int("other radius"))),
                {"grow": (SPOT,), "shrink": (SPOT, RESIZED)},
                (larger, "only smaller", true),
            ),
            (
                lambda found, s: found.acknowledge(robot, Symbol(s[r].life), Symbol(V)),
                {"acknowledge": (V,)},
                (keeps, "the Command says so"),
            ),
        ]
        for act, rules, answered in calls:
            sides = [[(f"{rule} ({r})", args)] for rule, args in rules.items()]
            yield Case(f"Roster: {' or '.join(rules)} ({r})", call(act), sides, answered, around=(V, LIFE))

    for robot, r in ids.items():
        yield from of_robot(robot, r)
    appear = [(f"appear ({r})", (z3.Const(f"body of {r}", DISK.z3),)) for r in ids.values()]
    settle = call(lambda found, _: found.settle(lambda member: Truth(z3.Bool(f"{member.robot} is free"))))
    put = ("it is put where that was announced",)
    yield Case("Roster.settle", settle, [[appear[0]], [appear[1]], appear], put, may_refuse=True)
    others = [[("concern_others", ())]]
    yield Case("Roster.follow_things", call(lambda found, _: found.follow_things((1,))), others)
    yield Case("Roster.follow_parts", call(lambda found, _: found.follow_parts((1,))), others)
