"""Proof cases of the ledger's rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import z3

from protocol.kernel.records import ANNOUNCED, GONE, PRESENT
from tests.proof.model import ANY_LINE, APART, BESIDE, CODE, INSIDE, LINE_OF, OTHER, REGION, invariant, real
from tests.proof.objects import SOURCE, holds_its_regions, ledger_of, ledger_state, outcome_of, own_claims
from tests.proof.outcomes import EPOCH, NAMES, NEXT, SAID, Case, Geometry, Outcome, S, any_body

Rule = Callable[[Any, Any, Any], object]  # executed on ledger, disk and other disk
Besides = Callable[[str, Outcome], None]  # adds what the rule means for the disk itself

_PLACES = {name: z3.Int(f"{x}.first place") for name, x in NAMES.items()}
_BECOMES = {"announce": ANNOUNCED, "appear": PRESENT, "remove": GONE}  # phase of the disk after a rule
_REGIONS = "/held/(acknowledged|granted|regions(/appended)?)"
_CHANGES = {  # frame condition: fields of its disk, or the disk itself, which a rule may change
    "rejoin": "/life", "settle": _REGIONS, "acknowledge": _REGIONS, "grant": f"/still|{_REGIONS}",
    "fence": f"/life|/still|{_REGIONS}", "announce": "", "appear": "/phase", "remove": "/phase",
}  # fmt: skip
_THIRDS = {"grant", "fence", "announce", "remove"}


def of_ledger(rule: str, does: Rule, x: str, besides: Besides | None = None, *given: Any) -> Case:
    """A rule of the ledger whose first disk is X."""
    changes = rf"disks/id\.{x}({_CHANGES[rule]})" if rule in _CHANGES else ""
    changes += rf"|pairs/(.*/)?id\.{x}(/.*)?" if rule in _THIRDS else ""

    def run() -> Outcome:
        geometry = Geometry()
        made = ledger_of(geometry, changes)
        does(made, made.disks[CODE[x]], made.disks[CODE[OTHER[x]]])
        outcome = outcome_of(made, geometry)
        outcome.claims |= history(outcome.after) | noted(geometry, outcome.after)
        if rule in _BECOMES:
            outcome.claims[f"{x}: is where it is said to be"] = outcome.after[f"{x}.phase"] == _BECOMES[rule]
        if besides is not None:
            besides(x, outcome)
        return outcome

    return Case(f"{rule} {x}", run, [*given])


def history(after: dict[str, Any]) -> dict[str, Any]:
    """Why a Tick of an earlier version lists each binding as of that version: each field of a binding changes
    once at most, at a version that it records."""
    v, version = S["v"], after["v"]
    changed = [f"{x}.{f}" for x in "AB" for f in ("phase", "life", "still", "granted")]
    changed += [f"{b}.{f}" for b in "LS" for f in ("on", "number", "since", "A.dead", "B.dead")]
    nothing = z3.And(*[after[f] == S[f] for f in changed])
    found = {"a change has a version": z3.And(version >= v, z3.Or(version > v, nothing))}
    for x in "AB":
        found[f"{x}: regions are numbered upwards"] = after[f"{x}.granted"] >= S[f"{x}.granted"]
    for b in "LS":
        new = z3.And(
            after[f"{b}.number"] == version,
            z3.Or(after[f"{b}.since"] == 0, after[f"{b}.since"] == version),
            *[z3.Or(after[f"{b}.{x}.dead"] == 0, after[f"{b}.{x}.dead"] == version) for x in "AB"],
        )
        same = z3.Or(*[z3.And(S[f"{old}.on"], *_goes_on(after, b, old)) for old in "LS"])
        found[f"{b}: is new or goes on"] = z3.Implies(after[f"{b}.on"], z3.Or(new, same))
        # While one life is asked, its binding with an earlier life of the other disk stays in force.
        asks = z3.And(same, after[f"{b}.on"], after[f"{b}.since"] == 0, after[f"{b}.number"] != S["S.number"])
        stays = z3.And(after["S.on"], after["S.number"] == S["S.number"])
        for x in "AB":
            mine = z3.And(after[f"{b}.asked"] == CODE[x], S["S.on"], S[f"S.{x}.dead"] == 0)
            found[f"{b}.{x}: what is kept meanwhile"] = z3.Implies(z3.And(asks, mine), stays)
    return found


def noted(geometry: Geometry, after: dict[str, Any]) -> dict[str, Any]:
    """The newest notes of the geometry cover all that each disk holds."""
    found = {}
    for x, note in geometry.noted.items():
        acked, granted = after[f"{x}.acked"], after[f"{x}.granted"]
        covers = z3.And(note.phase != GONE, note.acknowledged <= acked, note.granted >= granted)
        found[f"{x}: is noted"] = z3.Implies(after[f"{x}.phase"] != GONE, covers)
        if note.regions is not None:
            found[f"{x}: is noted as it is"] = holds_its_regions(note, x)
    return found


def _goes_on(after: dict[str, Any], b: str, old: str) -> Iterator[Any]:
    for kept in ("number", "asked", "A.life", "B.life"):
        yield after[f"{b}.{kept}"] == S[f"{old}.{kept}"]
    for once in ("since", "A.dead", "B.dead"):
        now, before = after[f"{b}.{once}"], S[f"{old}.{once}"]
        yield z3.Or(now == before, z3.And(before == 0, now == after["v"]))
    for x, y in (("A", "B"), ("B", "A")):
        lists = z3.Or(
            z3.And(after[f"{b}.since"] == 0, S[f"{old}.asked"] == CODE[x]), S[f"{old}.{y}.dead"] != 0
        )
        # A half-plane behind the place in an earlier Tick is behind the present place.
        yield z3.Implies(lists, z3.Implies(*[BESIDE[y](each[f"{y}.acked"], ANY_LINE) for each in (S, after)]))


def _settled(x: str, outcome: Outcome) -> None:
    outcome.assume(INSIDE[x](S[f"{x}.body"], NEXT))


def _fenced(x: str, outcome: Outcome) -> None:
    body = any_body(f"{x}.stands")  # with or without the part that it may carry
    there = S[f"{OTHER[x]}.phase"] == PRESENT
    outcome.stands(x, body)
    outcome.assume(
        z3.Or(body == S[f"{x}.body"], body == S[f"{x}.own"]),
        z3.Implies(z3.And(S[f"{x}.reach"], there), body == S[f"{x}.own"]),
        z3.Implies(z3.Not(S[f"{x}.still"]), INSIDE[x](body, NEXT)),  # the place passed to `fence`
    )


def _joined(x: str, outcome: Outcome) -> None:
    """The new life has a process as `RobotLife` initialises it."""
    outcome.begins(x)
    body = outcome.after[f"{x}.own"] = outcome.after[f"{x}.body"]
    life = outcome.after[f"{x}.life"]
    made = SOURCE.robot.RobotLife(CODE[x], life, body, Geometry())
    numbers = (made.version, made.number, made.offered_number, made.part)
    begun = z3.And(made.body == body, made.own == body, made.life == life, life == NEXT)
    heard = z3.Or(*[number != 0 for number in numbers])
    empty = made.region is made.offered is None and not made.ends and made.name == CODE[x]
    outcome.claims[f"{x}: has received nothing"] = z3.And(empty, begun, z3.Not(heard))


def _announced(x: str, outcome: Outcome) -> None:
    body = any_body(f"{x}.announced")
    outcome.stands(x, body)
    outcome.begins(x)
    outcome.assume(INSIDE[x](body, NEXT))


def _granted(x: str, outcome: Outcome) -> None:
    """Numbers between the newest region and this one are of no region of X; they stand for empty ones."""
    region = REGION[x]
    is_empty = z3.And(S[f"{x}.granted"] < region, region < NEXT)
    for so in (APART(*REGION.values()), BESIDE[x](region, ANY_LINE)):
        outcome.assume(z3.Implies(is_empty, so))


def _announce(made: Any, disk: Any) -> None:
    """Announce a disk that is in the ledger, or a new one."""
    if not made.pairs[disk.name] and z3.And(z3.Bool("is new"), disk.phase == GONE):
        del made.disks[disk.name], made.pairs[disk.name]
    found = made.announce(disk.name, NEXT)
    found.held.disk = NAMES[disk.name]


def _acknowledge(x: str) -> Case:
    """Any acknowledgement in transit arrives."""
    said = invariant({**S, f"{x}.said": SAID[x]})[f"{x}: acknowledgement"]
    return of_ledger("acknowledge", lambda m, d, _: m.acknowledge(d, SAID[x]), x, None, said)


def ledger_cases() -> Iterator[Case]:
    """Every rule of the ledger, for either disk, and one for third disks."""
    for x in "AB":
        yield of_ledger("rejoin", lambda m, d, _: m.rejoin(d), x, _joined)
        yield of_ledger("fence", lambda m, d, _: m.fence(d, NEXT), x, _fenced)
        yield of_ledger("grant", lambda m, d, _: m.grant(d, NEXT), x, _granted)
        yield of_ledger("remove", lambda m, d, _: m.remove(d), x)
        yield of_ledger("settle", lambda m, d, _: m.settle(d, NEXT), x, _settled)
        yield _acknowledge(x)
        yield of_ledger("ask", lambda m, d, o: m.ask(d, o), x)
        yield of_ledger("announce", lambda m, d, _: _announce(m, d), x, _announced)
        yield of_ledger("appear", lambda m, d, _: m.appear(d), x)
        yield of_ledger("part", lambda m, d, o: m.part(d, o), x)
        yield of_ledger("query: tied", lambda m, d, o: m.tied(d, o), x)
        yield of_ledger("query: grants", lambda m, d, _: m.grants_of(d), x)
    yield of_ledger("introduce", lambda m, d, o: m.introduce(d, o, LINE_OF(NEXT, 0)), "A")
    yield of_ledger("elsewhere", lambda m, *_: vars(m).update(version=m.version + 1), "A")
    for b, slot in (("L", "living"), ("S", "static")):
        yield _answer(b, slot)
    of_epoch = [place == EPOCH for place in _PLACES.values()]
    yield Case("begin", _begin, of_epoch, starts=True)
    yield Case("restart", _restart, of_epoch)


def _answer(b: str, slot: str) -> Case:
    def does(made: Any, *_: Any) -> None:
        binding = getattr(made.pairs[CODE["A"]][CODE["B"]], slot)
        made.answer(binding, LINE_OF(S[f"{b}.number"], 0))

    asked = [S[f"{b}.on"], S[f"{b}.frozen"], S[f"{b}.asked"] != 0]
    return Case(f"answer {b}", of_ledger("answer", does, "A").run, asked)


def _begin() -> Outcome:
    """The first ledger, of disjoint disks."""
    outcome = _restart()
    outcome.assumptions = []
    outcome.assume(EPOCH > 0, *[INSIDE[x](outcome.after[f"{x}.body"], EPOCH) for x in "AB"])
    outcome.assume(invariant(outcome.after)["safe"], *[S[f"{x}.granted"] < EPOCH for x in "AB"])
    outcome.after |= {f"{x}.said": 0 for x in "AB"}
    return outcome


def _restart() -> Outcome:
    """A new coordinator: a ledger of a new epoch, with the disks at their present places."""
    geometry = Geometry()
    made = SOURCE.ledger.Ledger(EPOCH, _PLACES, geometry)
    outcome = Outcome()
    has = [made.disks[name].held.regions[0][1] is place for name, place in _PLACES.items()]
    after = outcome.after = ledger_state(made)
    outcome.assume(S["v"] < EPOCH)
    outcome.claims = noted(geometry, after) | own_claims(made)
    outcome.claims["a version of its epoch"] = after["v"] == EPOCH
    outcome.claims["each disk has its place"] = all(has)
    for x in "AB":
        outcome.claims[f"{x}: regions"] = holds_its_regions(made.disks[CODE[x]].held, x)
        outcome.claims[f"{x}: is there"] = after[f"{x}.phase"] == PRESENT
        body = any_body(f"{x}.restarted")
        after[f"{x}.phase"] = z3.If(S[f"{x}.phase"] == PRESENT, PRESENT, GONE)
        outcome.begins(x)
        outcome.stands(x, body)
        outcome.assume(INSIDE[x](body, EPOCH), body == real(S, x))
    return outcome
