"""Proof cases of a robot's rules, and of the content of Ticks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import z3

from protocol.kernel.records import PRESENT
from protocol.kernel.robot import ASKED, HALF
from tests.proof.containers import Frame, SymbolicList, with_optional
from tests.proof.model import CODE, LINE, LINE_OF, OTHER, THIRDS, end_fields, ends, process_fields, smaller
from tests.proof.objects import EARLIER, SOURCE, UNKNOWN, end_claims, end_of, ledger_of, outcome_of, robot_of
from tests.proof.outcomes import OBEYED, PART, PROPOSED, Case, Geometry, Outcome, S, any_body

OfEnd = Callable[[Any, Any, Outcome], object]  # executed on process, end and outcome


def of_end(rule: str, b: str, x: str, does: OfEnd, *given: Any, alone: bool = False) -> Case:
    """A rule of one end in a process of the present or an earlier life; `alone`: the process has no other end
    of a binding in force."""

    def run() -> Outcome:
        geometry = Geometry()
        others = [] if alone else [each for each in ends_of(x, S[f"{b}.{x}.life"]) if each != b]
        bounds = [end_of(each, x) for each in (b, *others)]
        end, made = bounds[0], robot_of(x, geometry, bounds)
        frame = Frame(made, rf"ends/{b}\.number/(state|half|lines(/.*)?)")
        outcome = Outcome(geometry)
        does(made, end, outcome)
        read = end.obeyed
        outcome.after |= end_fields(b, x, end)
        outcome.claims |= end_claims(end, outcome.after, b, x)
        outcome.claims[f"{x}: nothing else changes"] = frame.holds and read == end.obeyed
        return outcome

    return Case(f"{rule} {x} {b}", run, [S[f"{b}.on"], S[f"{b}.{x}.has"], *given])


def of_robot(rule: str, x: str, does: Callable[[str, Any, Outcome], None], changing: str) -> Case:
    """A rule of the present life of X, the only one that its base obeys, which changes these fields."""

    def run() -> Outcome:
        geometry = Geometry()
        made = robot_of(x, geometry, [end_of(b, x) for b in ends_of(x, S[f"{x}.life"])])
        frame, outcome = Frame(made, changing), Outcome(geometry)
        does(x, made, outcome)
        outcome.after |= process_fields(x, made)
        outcome.claims[f"{x}: nothing else changes"] = frame.holds
        return outcome

    return Case(f"{rule} {x}", run, [S[f"{x}.life"] != 0, S[f"{x}.phase"] == PRESENT])


def ends_of(x: str, life: Any, *, taken: bool = True) -> list[str]:
    """Bindings in force with an end of this life of X; with `taken`, those in its process."""
    return [
        b
        for b in "LS"
        if z3.And(S[f"{b}.on"], S[f"{b}.{x}.life"] == life, z3.Or(S[f"{b}.{x}.has"], not taken))
    ]


def robot_cases() -> Iterator[Case]:
    """Every rule of a robot; numbers of bindings are distinct."""
    distinct = z3.Distinct(S["L.number"], S["S.number"], UNKNOWN, *_NUMBERS)
    for case in _cases():
        yield Case(case.rule, case.run, [*case.given, distinct])


def _cases() -> Iterator[Case]:
    for b in "LS":
        yield from _line_cases(b)
        for x in "AB":
            yield of_end("query:", b, x, _ask, alone=True)
            yield _freeze("freeze", b, x)
    for x in "AB":
        line, half, held = _line("L", 0), S[f"S.{x}.half"], _line("S", OBEYED["S"])
        kept = z3.If(S[f"S.{x}.state"] == HALF, half, held)
        yield _freeze("freeze kept", "L", x, S["S.on"], S[f"S.{x}.has"], S[f"S.{x}.static"], line == kept)
        # No Tick lists a living binding as static.
        yield of_end("turn", "S", x, lambda made, end, _: made.turn(end, HALF_PLANE))
        yield of_robot("adopt region", x, _adopt, "number|region")
        yield of_robot("command", x, _command, "body|own|part")
        yield of_robot("locate", x, _locate, "body|own")
        yield Case(f"say region {x}", partial(_say, x), [S[f"{x}.life"] != 0, S[f"{x}.phase"] == PRESENT])
        yield Case(f"receive {x}", partial(_receive, x, ""), _received(x))
        yield Case(f"receive {x} late", partial(_receive, x, "S"), _received_late(x))


def _line(b: str, number: Any) -> z3.ExprRef:
    return LINE_OF(S[f"{b}.number"], number)


def _line_cases(b: str) -> Iterator[Case]:
    """Rules of the line of a binding; answers are late, repeated or lost."""
    line, proposed = _line(b, S[f"{b}.A.number"] + 1), _line(b, PROPOSED)
    answer = S[f"{b}.h2"], S[f"{b}.s2"]
    has_lines = {x: S[f"{b}.{x}.state"] != ASKED for x in "AB"}
    is_said = [PROPOSED >= 1, ends(S, b)["number"] >= PROPOSED]

    def propose(made: Any, end: Any, outcome: Outcome) -> None:
        end.lines.propose(line, made.fits(end, line))
        outcome.claims["a line has its own number"] = end.lines.number == S[f"{b}.A.number"] + 1

    def adopt(made: Any, end: Any, _: Outcome) -> None:
        end.lines.on_proposal(PROPOSED, proposed, made.fits(end, proposed))

    yield of_end("propose", b, "A", propose, has_lines["A"])
    yield of_end("adopt", b, "B", adopt, has_lines["B"], *is_said)
    yield of_end("read answer", b, "A", lambda _, end, __: end.lines.on_answer(*answer), has_lines["A"])
    yield Case(f"send answer {b}", lambda: _send(b), [S[f"{b}.on"], S[f"{b}.B.has"]])


def _send(b: str) -> Outcome:
    outcome = Outcome()
    for h, s, sent in (("h", "s", "first"), ("h2", "s2", "second")):
        sends = z3.And(z3.Bool(sent), S[f"{b}.B.state"] != ASKED)
        outcome.after[f"{b}.{h}"] = z3.If(sends, S[f"{b}.B.held"], S[f"{b}.{h}"])
        outcome.after[f"{b}.{s}"] = z3.If(sends, S[f"{b}.B.seen"], S[f"{b}.{s}"])
    return outcome


HALF_PLANE = z3.Const("half", LINE)


def _ask(made: Any, end: Any, _: Outcome) -> None:
    made.fits(end, HALF_PLANE), made.behind(end, HALF_PLANE), made.kept(end), end.obeyed


def _freeze(rule: str, b: str, x: str, *given: Any) -> Case:
    """An end finds its first line. A static binding in the same Tick is in force (`history`)."""

    def freeze(made: Any, end: Any, outcome: Outcome) -> None:
        made.freeze(end, _line(b, 0))
        outcome.after[f"{b}.frozen"] = True

    return of_end(rule, b, x, freeze, z3.Not(EARLIER[x]), *given)


def _adopt(x: str, made: Any, outcome: Outcome) -> None:
    made.adopt()
    outcome.claims[f"{x}: the region of its number"] = made.region == made.number


def _command(x: str, made: Any, outcome: Outcome) -> None:
    body, own = any_body("next body"), any_body("next own")
    made.command(body, own, PART)
    outcome.after[f"{x}.reach"] = made.part == CODE[OTHER[x]]
    outcome.assume(*smaller(x, own, body))
    kept = z3.And(made.body == body, made.own == own, made.part == PART)
    outcome.claims[f"{x}: what is covered from now on"] = kept


def _locate(x: str, made: Any, outcome: Outcome) -> None:
    """The body shrinks: a command has expired, or the estimate is better."""
    body, own = any_body(f"{x}.less body"), any_body(f"{x}.less own")
    made.locate(body, own)
    for less, more in ((body, S[f"{x}.body"]), (own, S[f"{x}.own"]), (own, body)):
        outcome.assume(*smaller(x, less, more))
    outcome.claims[f"{x}: what is covered"] = z3.And(made.body == body, made.own == own)


def _say(x: str) -> Outcome:
    """The present life acknowledges the region that it obeys."""
    outcome = Outcome()
    outcome.after[f"{x}.said"] = z3.If(S[f"{x}.obeyed"] != 0, S[f"{x}.obeyed"], S[f"{x}.said"])
    return outcome


AT, NUMBER = z3.Int("received"), z3.Int("received region")
LIFE, TO = z3.Int("receiving life"), z3.Int("addressed life")


def _received(x: str) -> list[Any]:
    """The present life receives a Tick of any version."""
    present = [S[f"{x}.life"] == LIFE, LIFE != 0, S[f"{x}.phase"] == PRESENT]
    sent = [S["v"] >= AT, AT >= TO, NUMBER <= AT]
    return [*present, *sent, z3.Implies(LIFE == TO, S[f"{x}.granted"] >= NUMBER)]


def _received_late(x: str) -> list[Any]:
    """An earlier life receives a Tick, sent before it ended."""
    over = [S["S.on"], S[f"S.{x}.life"] == LIFE, LIFE != 0, S[f"S.{x}.dead"] != 0]
    return [*over, z3.Implies(LIFE == TO, S[f"S.{x}.dead"] > AT)]


def _listed(x: str, place: Any) -> list[Any]:
    """The bindings in force of the life of X to which a Tick of this version is sent, as it lists them."""
    y, listed = OTHER[x], []
    for b in ends_of(x, TO, taken=False):
        begun = z3.And(S[f"{b}.since"] != 0, S[f"{b}.since"] <= AT)
        if z3.And(S[f"{b}.number"] <= AT, z3.Or(begun, S[f"{b}.asked"] == CODE[x])):
            static = z3.And(S[f"{b}.{y}.dead"] != 0, S[f"{b}.{y}.dead"] <= AT)
            each = SOURCE.records.Listed(S[f"{b}.number"], CODE[y], None, place, static)
            listed.append(with_optional(each, first=(_line(b, 0), begun)))
    return listed


_NUMBERS = z3.Ints("first_listed last_listed")  # of bindings with third disks


def _is_taken(made: Any, listed: Any) -> bool:
    """Whether the process has adopted a binding with a third disk as listed."""
    end = made.ends.get(listed.number)
    if end is None:
        return False
    lines = [] if listed.first is None else [listed.first]
    kept = zip(end.obeyed, lines, strict=True)
    same = all(getattr(end, each) is getattr(listed, each) for each in ("peer", "place", "static"))
    return same and end.low == (made.name < listed.peer) and all(mine is line for mine, line in kept)


def _receive(x: str, late: str) -> Outcome:
    """A life receives a Tick, which lists every binding in force as of its version (`history`)."""
    geometry = Geometry()
    known = [end_of(b, x, z3.Int(f"{b}.place before")) for b in ends_of(x, LIFE)]
    made = robot_of(x, geometry, known)
    made.life = LIFE
    if late:
        made.version = S[f"{late}.{x}.taken"]
    each = zip(_NUMBERS, [*THIRDS][::2], (z3.Const("listed line", LINE), None), strict=False)
    at = z3.Int("listed place"), z3.Bool("listed static")
    others = [SOURCE.records.Listed(*third, *at) for third in each]
    place = S[f"{OTHER[x]}.acked"] if z3.Bool("is unknown") else None  # both are possible
    listed = [others[0], *_listed(x, place), others[1]]
    frames = [Frame(end, "place|static") for end in made.ends.values()]
    frames.append(Frame(made, "version|offered_number|offered|ends"))
    made.receive(SOURCE.records.LifeGrants(TO, AT, NUMBER, NUMBER, SymbolicList(lambda: listed)))
    outcome = Outcome(geometry)
    after, claims = outcome.after, outcome.claims
    if late:
        after[f"{late}.{x}.taken"] = made.version
    else:
        after[f"{x}.taken"], after[f"{x}.offered"] = made.version, made.offered_number
    claims[f"{x}: offered"] = made.offered == made.offered_number
    claims[f"{x}: nothing else changes"] = all(frame.holds for frame in frames)
    claims[f"{x}: takes others alike"] = all(_is_taken(made, each) for each in others)
    for b in ends_of(x, LIFE, taken=False):
        after[f"{b}.{x}.has"] = False
        for end in made.ends.values():
            if end.number == S[f"{b}.number"]:
                if end in known:
                    after |= {f"{b}.{x}.has": True, f"{b}.{x}.static": end.static}
                    claims[f"{b}.{x}: its lines"] = end.of == b
                else:
                    after |= end_fields(b, x, end)
                    claims |= end_claims(end, after, b, x)
                claims[f"{b}.{x}: its place"] = end.place is place
                claims[f"{b}.{x}: its ends"] = end.peer == CODE[OTHER[x]] and end.low == (x == "A")
    return outcome


def message_cases() -> Iterator[Case]:
    """The ledger's present Tick is as the rule `receive` assumes, at this version."""
    for x in "AB":
        now = [S["v"] == AT, S[f"{x}.life"] == LIFE, LIFE == TO, TO != 0]
        yield Case(f"message {x}", partial(_message_now, x), now)


def _message_now(x: str) -> Outcome:
    geometry = Geometry()
    made = ledger_of(geometry)
    grants, place = made.grants_of(made.disks[CODE[x]]), S[f"{OTHER[x]}.acked"]
    listed = _listed(x, place if S[f"{OTHER[x]}.still"] else None)
    granted, pairs = S[f"{x}.granted"], made.pairs[CODE[x]]
    thirds = [each.peer for each in grants.bindings if each.peer not in CODE.values()]
    outcome, own = outcome_of(made, geometry), SOURCE.records.LifeGrants
    outcome.claims |= {
        "grants: what it obeys": _same(grants, own(TO, AT, granted, granted, grants.bindings)),
        "grants: its bindings": z3.And(
            len(grants.bindings) == len(listed) + len(thirds),
            *[z3.Or(*[_same(one, each) for one in grants.bindings]) for each in listed],
        ),
        "grants: others": thirds == [each for each in THIRDS if each in pairs and THIRDS[each] != "loose"],
    }
    return outcome


def _same(one: Any, other: Any) -> Any:
    """Whether two records have equal fields."""
    return z3.And(*[value == getattr(other, name) for name, value in vars(one).items()])
