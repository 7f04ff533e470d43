"""One pair of robots, the coordinator, and a network that does what it likes: the variables, and the rules.

The robot with the lower id is the owner `o` of the line, the other the follower `f`; a static obstacle is a
robot that never lives. Rules of both ends are stated once, for a robot `r` and its peer `q`.

*Lives* are numbered upwards. Of every life that ever was, the process may go on for ever: it hears and talks.

*Messages*: a State names the life that speaks, and may be heard whenever that life has begun, any number of
times, in any order, or never. What it says of the line are proposals, of which each that was ever made may
be heard, and answers, of which each that was ever `said` may be. So may every version of the roster.

*Where a disk is* is an individual of the sort Disk: centre and radius. `body` is what is really there, `disk`
what the robot takes itself for, which may be larger, and is what it keeps to lines.

*Half-planes* are individuals of the sort Line; the owner stays `left` of it, the follower `right`. The one
between the own disk and a place is a Line too, with the place on the other side.
"""

from __future__ import annotations

from collections.abc import Iterator

from tests.proof.engine.logic import BOOL, INT, Relation, Sort, Term, every, implies, no, pick, some
from tests.proof.engine.state import EACH, Schema, State, Variable, flag, number
from tests.proof.engine.system import Need, System

LIFE = VERSION = NUMBER = INT
LINE, DISK = Sort("Line"), Sort("Disk")
OWNER, FOLLOWER = "o", "f"
BOTH = ((OWNER, FOLLOWER), (FOLLOWER, OWNER))  # a robot and its peer
EITHER = ((OWNER,), (FOLLOWER,))
GONE, ANNOUNCED, STATIC, LIVE = range(4)  # what a roster says of a robot

_EITHER: Schema = {
    # The coordinator's roster at present, and what each version said.
    "life": number(),
    "status": number(),
    "place": Variable((), DISK),  # where a static disk is, or one that was announced
    "kept_life": number(),  # newest acknowledgement: of which life,
    "kept": number(),  # and of which version
    "was_life": number(VERSION),
    "was_status": number(VERSION),
    "was_place": Variable((VERSION,), DISK),
    # Where the disk is.
    "body": Variable((), DISK),
    "disk": Variable((), DISK),
    # What one life knows of the peer (`RobotPair`, `KnownRoster`).
    "known": number(LIFE),  # newest version of the roster that it heard, 0 for none
    "keeps": number(LIFE),  # newest one that it keeps to, which its Commands say
    "peer": number(LIFE),  # newest life of the peer that it knows of; older ones are ignored
    "heard": number(LIFE),  # newest one that it heard
    "talks": flag(LIFE),  # whether a State of the life `peer` is at hand
    "excused": flag(LIFE),  # whether the peer's disk is not in the workspace, as far as it knows
    "stands": flag(LIFE),  # whether it keeps off a place where the peer's disk is static or announced,
    "spot": Variable((LIFE,), DISK),  # this one;
    "clear": flag(LIFE),  # whether it has a half-plane towards that place yet,
    "tangent": Variable((LIFE,), LINE),  # this one
    # Of no process: what the proof has to remember.
    "born": number(LIFE),  # the version that admitted a life, 0 for none
    "ground": Variable((LIFE,), DISK),  # where the disk is, or was when the life ended
    "mover": number(),  # the newest life that has moved the disk
    "since": number(),  # the version that announced the place where the disk was put
}
_OWNER: Schema = {
    "met": flag(LIFE),  # whether the life `peer` has been heard
    "number": number(LIFE),  # of the newest proposal
    "seen": number(LIFE),  # highest number that is known to be answered
    "line": Variable((LIFE, NUMBER), LINE),  # that was proposed by this number; 0: the initial line
    "to": number(LIFE, NUMBER),  # the follower's life that it was proposed to
    "proposed": flag(LIFE, NUMBER),  # whether it is unanswered
    "inherited": flag(LIFE, NUMBER),  # whether an earlier life of the follower may have held it
    "holds": flag(LIFE),  # whether the follower is known to hold a line in its present life,
    "held": number(LIFE),  # this one
    "agreed": flag(LIFE),  # whether any life of the follower is known to have held a line of this one
    "bound": flag(LIFE),  # for the proof: whether the follower's disk is right of a line of this life,
    "witness": number(LIFE),  # this one
}
_FOLLOWER: Schema = {
    "seen": number(LIFE),  # highest number answered
    "linked": flag(LIFE),  # whether the held line is one of the life `peer`
    "held": number(LIFE),  # number of the held line, 0 if it is not linked, or holds the initial line
    "holds": flag(LIFE),  # whether it holds a line: number `holding` of the owner's life `holding_of`
    "holding_of": number(LIFE),
    "holding": number(LIFE),
    "said": flag(
        LIFE, LIFE, NUMBER, NUMBER
    ),  # answers: to which life, which number is held, up to which is seen
}
SCHEMA: Schema = {
    "version": number(),
    **{f"{side}.{name}": variable for side in (OWNER, FOLLOWER) for name, variable in _EITHER.items()},
    **{f"o.{name}": variable for name, variable in _OWNER.items()},
    **{f"f.{name}": variable for name, variable in _FOLLOWER.items()},
}

left, right = Relation("left", (DISK, LINE)), Relation("right", (DISK, LINE))
apart = Relation("apart", (DISK, DISK))  # the owner's disk, the follower's
within = Relation("within", (DISK, DISK))
PAIR = System(SCHEMA, (left, right, apart, within))


@PAIR.axiom
def a_line_parts(one: DISK, other: DISK, line: LINE) -> Term:
    """Two disks on the two sides of a line are apart."""
    return implies(every(left(one, line), right(other, line)), apart(one, other))


@PAIR.axiom
def smaller_stays_left(one: DISK, other: DISK, line: LINE) -> Term:
    """What lies within a disk that is left of a line is left of it."""
    return implies(every(within(one, other), left(other, line)), left(one, line))


@PAIR.axiom
def smaller_stays_right(one: DISK, other: DISK, line: LINE) -> Term:
    """And right of it, if that disk is."""
    return implies(every(within(one, other), right(other, line)), right(one, line))


@PAIR.axiom
def smaller_owners_stay_apart(one: DISK, other: DISK, far: DISK) -> Term:
    """What lies within an owner's disk that is apart is apart."""
    return implies(every(within(one, other), apart(other, far)), apart(one, far))


@PAIR.axiom
def smaller_followers_stay_apart(one: DISK, other: DISK, far: DISK) -> Term:
    """And within a follower's."""
    return implies(every(within(one, other), apart(far, other)), apart(far, one))


@PAIR.axiom
def within_is_transitive(one: DISK, other: DISK, third: DISK) -> Term:
    """Within what lies within."""
    return implies(every(within(one, other), within(other, third)), within(one, third))


def inside(one: Term, other: Term) -> Term:
    """Whether a disk is another one, or lies within it."""
    return some(one == other, within(one, other))


def fits(r: str, disk: Term, line: Term) -> Term:
    """Whether a disk is on the robot's side of a line."""
    return left(disk, line) if r == OWNER else right(disk, line)


def present(s: State, r: str) -> Term:
    """Whether the robot's disk is in the workspace."""
    return s[r].status >= STATIC


def agreed(s: State, r: str, a: Term) -> Term:
    """Whether a life keeps to a line of which it knows that the peer has held it (`end.agreed`)."""
    return s.o.agreed[a] if r == OWNER else s.f.holds[a]


def obeys(s: State, a: Term, k: Term) -> Term:
    """Whether an owner's life obeys its line of this number (`Owner.obeyed`)."""
    return some(s.o.inherited[a, k], s.o.proposed[a, k], every(s.o.holds[a], s.o.held[a] == k))


def held_line(s: State, b: Term) -> Term:
    """The line that a follower's life holds."""
    return s.o.line[s.f.holding_of[b], s.f.holding[b]]


def ready(s: State, r: str, a: Term) -> Term:
    """Whether a life may move, as far as this peer is concerned (`RobotPair.ready`)."""
    return some(s[r].excused[a], agreed(s, r, a), every(s[r].stands[a], s[r].clear[a]))


# -- the coordinator


def publish(s: State, n: State) -> None:
    """What the roster says now has the next version."""
    v = s.version + 1
    n.version = v
    for r in (OWNER, FOLLOWER):
        n[r].was_life[v], n[r].was_status[v], n[r].was_place[v] = n[r].life, n[r].status, n[r].place


def begin_life(n: State, r: str, life: Term) -> None:
    """A process has just begun: it knows nothing."""
    me = n[r].at(life)
    me.known = me.keeps = me.peer = me.heard = me.seen = me.held = 0
    me.talks = me.excused = me.stands = me.clear = me.holds = False
    if r == OWNER:
        me.met = me.agreed = me.bound = False
        me.number = 0
        me.proposed = me.inherited = lambda _: False
    else:
        me.linked = False
        me.said = lambda *_: False


def begin_founding(n: State, r: str, life: Term, theirs: Term, fitting: Term) -> None:
    """A process that knows the initial line, if one fits, with a peer's founding life."""
    me = n[r].at(life)
    me.peer, me.holds = theirs, fitting
    if r == OWNER:
        me.agreed = me.bound = fitting
        me.witness = 0
    else:
        me.linked, me.holding_of, me.holding = fitting, theirs, 0


@PAIR.start
def found(
    n: State,
    version: VERSION,
    o_there: BOOL,
    f_there: BOOL,
    o_life: LIFE,
    f_life: LIFE,
    o_disk: DISK,
    f_disk: DISK,
    fitting: BOOL,
    initial: LINE,
) -> Iterator[Need]:
    """The run begins. Of the robots that are there, those with a process begin their founding lives, which
    know the initial line, unless none fits; the others are static at their starts."""
    yield "disks are apart at the start", implies(every(o_there, f_there), apart(o_disk, f_disk))
    yield (
        "the initial line lies between the starts",
        implies(fitting, every(o_there, f_there, left(o_disk, initial), right(f_disk, initial))),
    )
    yield "versions and lives count upwards", every(version >= 0, o_life >= 0, f_life >= 0)
    yield "nothing lives where no disk is", every(some(o_there, o_life == 0), some(f_there, f_life == 0))
    n.version = version
    for r, there, life, disk in ((OWNER, o_there, o_life, o_disk), (FOLLOWER, f_there, f_life, f_disk)):
        me = n[r]
        me.life, me.status = life, pick(there, pick(life > 0, LIVE, STATIC), GONE)
        me.place = me.body = me.disk = me.ground[life] = disk
        me.kept_life = me.kept = me.mover = 0
        me.since = version
        me.was_life[EACH] = me.was_status[EACH] = 0
        if r == OWNER:
            me.number[EACH] = 0
        me.born[EACH] = lambda a, life=life: pick(every(a == life, a > 0), version + 1, 0)
        begin_life(n, r, life)
    begin_founding(n, OWNER, o_life, f_life, fitting)
    begin_founding(n, FOLLOWER, f_life, o_life, fitting)
    n.o.line[o_life, 0] = initial
    publish(n, n)


@PAIR.rule(*EITHER)
def admit(s: State, n: State, r: str, life: LIFE) -> Iterator[Need]:
    """Another life of a robot takes part (`Roster.admit`); its disk is where the earlier one left it."""
    yield "only where the disk is", present(s, r)
    yield "only a life with a new number", life > s[r].life
    me = n[r]
    me.life, me.status, me.disk = life, LIVE, s[r].body
    me.born[life], me.ground[life] = s.version + 1, s[r].body
    begin_life(n, r, life)
    publish(s, n)


@PAIR.rule(*EITHER)
def fence(s: State, n: State, r: str, place: DISK) -> Iterator[Need]:
    """The present life of a robot is over; its disk is static (`Roster.fence`)."""
    yield "only what lives", s[r].status == LIVE
    yield "what is said of the place is true", inside(s[r].body, place)
    me = n[r]
    me.status, me.place, me.disk, me.ground[s[r].life] = STATIC, place, s[r].body, s[r].body
    publish(s, n)


@PAIR.rule(*EITHER)
def announce(s: State, n: State, r: str, place: DISK) -> Iterator[Need]:
    """A disk is to appear; nothing is there yet (`Roster.announce`)."""
    yield "only of what is gone", s[r].status == GONE
    n[r].status, n[r].place = ANNOUNCED, place
    publish(s, n)


@PAIR.rule(*EITHER)
def withdraw(s: State, n: State, r: str) -> Iterator[Need]:
    """What was announced does not appear (`Roster.withdraw`)."""
    yield "only what was announced", s[r].status == ANNOUNCED
    n[r].status = GONE
    publish(s, n)


@PAIR.rule(*BOTH)
def appear(s: State, n: State, r: str, q: str, body: DISK) -> Iterator[Need]:
    """A disk that was announced is put in its place, and is static (`Roster.settle`)."""
    yield "only what was announced", s[r].status == ANNOUNCED
    yield (
        "a live robot has acknowledged the version that announces it",
        implies(s[q].status == LIVE, s[q].kept == s.version),
    )
    yield (
        "the acknowledgement is of its present life",
        implies(s[q].status == LIVE, s[q].kept_life == s[q].life),
    )
    yield (
        "no static disk reaches there",
        implies(s[q].status == STATIC, apart(s.o.place, s.f.place)),
    )
    yield "it is put where that was announced", inside(body, s[r].place)
    me = n[r]
    me.status, me.body, me.disk, me.since = STATIC, body, body, s.version
    publish(s, n)


@PAIR.rule(*EITHER)
def remove(s: State, n: State, r: str) -> Iterator[Need]:
    """A static disk is taken away (`Roster.remove`)."""
    yield "only what is static", s[r].status == STATIC
    n[r].status = GONE
    publish(s, n)


@PAIR.rule(*EITHER)
def grow(s: State, n: State, r: str, body: DISK) -> Iterator[Need]:
    """A live robot has another size (`Roster.resize`): it took up a part, or put it down."""
    yield "only what lives", s[r].status == LIVE
    yield "only the disk that the robot keeps to all lines", inside(body, s[r].disk)
    n[r].body = body
    publish(s, n)


@PAIR.rule(*EITHER)
def shrink(s: State, n: State, r: str, body: DISK, place: DISK) -> Iterator[Need]:
    """A static disk is a smaller one (`Roster.resize`): a part was taken from it."""
    yield "only what is static", s[r].status == STATIC
    yield "only smaller", inside(body, s[r].body)
    yield "what is said of the place is true", inside(body, place)
    me = n[r]
    me.body, me.disk, me.place = body, body, place
    publish(s, n)


@PAIR.rule()
def concern_others(s: State, n: State) -> Iterator[Need]:
    """The roster says something else of other robots, or of obstacles."""
    yield "nothing else is needed", True
    publish(s, n)


@PAIR.rule(*EITHER)
def acknowledge(s: State, n: State, r: str, v: VERSION) -> Iterator[Need]:
    """A Command of the present life is taken, which says to which version it keeps (`Roster.acknowledge`)."""
    a = s[r].life
    yield "only of a life that is not over", s[r].status == LIVE
    yield "the Command says so", every(v > 0, v <= s[r].keeps[a])
    yield "only what is newer", some(a > s[r].kept_life, every(a == s[r].kept_life, v > s[r].kept))
    n[r].kept_life, n[r].kept = a, v


# -- what both ends of a line do


def acts(s: State, r: str, a: Term) -> Term:
    """Whether a life has begun, and has heard a roster: before that it knows nothing of its peers."""
    return every(s[r].born[a] > 0, s[r].known[a] > 0)


def talk_with(s: State, n: State, r: str, a: Term, life: Term) -> None:
    """Older lives of the peer do not count any more (`Owner._begin`, `Follower.expect`)."""
    me = n[r].at(a)
    me.peer = life
    if r == OWNER:
        me.inherited = lambda k: obeys(s, a, k)
        me.proposed = lambda _: False
        me.holds, me.held, me.seen, me.met = False, 0, s.o.number[a], False
    else:
        me.linked, me.held, me.seen = False, 0, 0


def end_of(s: State, n: State, r: str, a: Term, life: Term) -> None:
    """No life of the peer up to this one moves again: its disk, or nothing, replaces all lines (`fence`)."""
    me, known = n[r].at(a), s[r].at(a)
    me.talks = False
    if r == OWNER:
        talk_with(s, n, r, a, life + 1)
        me.inherited = lambda _: False
        me.agreed = me.bound = False
    else:
        newer = life + 1 > known.peer
        me.peer = pick(newer, life + 1, known.peer)
        me.linked = every(known.linked, no(newer))
        me.held, me.seen = pick(newer, 0, known.held), pick(newer, 0, known.seen)
        me.holds = False


def told(s: State, n: State, r: str, a: Term, v: Term) -> Iterator[Need]:
    """A life hears a version of the roster (`KnownRoster.update`)."""
    yield "the life has begun", s[r].born[a] > 0
    yield "a version is told while it is the newest", every(v <= s.version, s[r].was_life[v] == a)
    yield "older versions are ignored", v > s[r].known[a]
    n[r].known[a] = v


@PAIR.rule(*BOTH)
def hear_nothing_new(s: State, n: State, r: str, q: str, a: LIFE, v: VERSION) -> Iterator[Need]:
    """The roster says the same of the peer as before."""
    k = s[r].known[a]
    yield from told(s, n, r, a, v)
    yield "it has heard one before", k > 0
    yield "of the same life", s[q].was_life[v] == s[q].was_life[k]
    yield "the same status", s[q].was_status[v] == s[q].was_status[k]
    yield (
        "and the same place",
        some(s[q].was_status[v] == LIVE, s[q].was_status[v] == GONE, s[q].was_place[v] == s[q].was_place[k]),
    )


@PAIR.rule(*BOTH)
def hear_too_late(s: State, n: State, r: str, q: str, a: LIFE, v: VERSION) -> Iterator[Need]:
    """The roster says something of a life before the one that was heard (`RobotPair.on_member`)."""
    yield from told(s, n, r, a, v)
    yield "a newer life was heard", s[q].was_life[v] < s[r].heard[a]


@PAIR.rule(*BOTH)
def hear_that_it_lives(s: State, n: State, r: str, q: str, a: LIFE, v: VERSION) -> Iterator[Need]:
    """The roster says that a life of the peer moves that is known (`RobotPair._expect`)."""
    yield from told(s, n, r, a, v)
    yield "it lives", s[q].was_status[v] == LIVE
    yield "no newer life was heard", s[q].was_life[v] >= s[r].heard[a]
    yield "the life is known", s[q].was_life[v] <= s[r].peer[a]
    n[r].excused[a] = False


@PAIR.rule(*BOTH)
def hear_of_a_new_life(s: State, n: State, r: str, q: str, a: LIFE, v: VERSION) -> Iterator[Need]:
    """The roster says that a life of the peer moves that was not known (`RobotPair._expect`)."""
    yield from told(s, n, r, a, v)
    yield "it lives", s[q].was_status[v] == LIVE
    yield "no newer life was heard", s[q].was_life[v] >= s[r].heard[a]
    yield "the life is new", s[q].was_life[v] > s[r].peer[a]
    talk_with(s, n, r, a, s[q].was_life[v])
    n[r].excused[a] = n[r].talks[a] = False


@PAIR.rule(*BOTH)
def hear_of_a_place(s: State, n: State, r: str, q: str, a: LIFE, v: VERSION) -> Iterator[Need]:
    """The roster says that the peer's disk is static, or is to appear (`RobotPair._stand`)."""
    yield from told(s, n, r, a, v)
    yield "there is a place", some(s[q].was_status[v] == STATIC, s[q].was_status[v] == ANNOUNCED)
    yield "no newer life was heard", s[q].was_life[v] >= s[r].heard[a]
    end_of(s, n, r, a, s[q].was_life[v])
    me = n[r].at(a)
    me.stands, me.clear, me.spot = True, False, s[q].was_place[v]
    me.excused = s[q].was_status[v] == ANNOUNCED


@PAIR.rule(*BOTH)
def hear_that_it_is_gone(s: State, n: State, r: str, q: str, a: LIFE, v: VERSION) -> Iterator[Need]:
    """The roster says that the peer's disk is not in the workspace (`RobotPair._release`)."""
    yield from told(s, n, r, a, v)
    yield "it is gone", s[q].was_status[v] == GONE
    yield "no newer life was heard", s[q].was_life[v] >= s[r].heard[a]
    end_of(s, n, r, a, s[q].was_life[v])
    me = n[r].at(a)
    me.stands, me.clear, me.excused = False, False, True


def heard_from(n: State, r: str, a: Term, life: Term) -> None:
    """A State of the peer's newest life is at hand (`RobotPair.accept`)."""
    me = n[r].at(a)
    me.heard, me.talks, me.excused = life, True, False
    if r == OWNER:
        me.met = True


@PAIR.rule(*BOTH)
def hear_it_speak(s: State, n: State, r: str, q: str, a: LIFE, life: LIFE) -> Iterator[Need]:
    """A State of the peer's life is heard that is known to be its newest (`RobotPair.accept`)."""
    yield "it has heard a roster", acts(s, r, a)
    yield "that life has begun", s[q].born[life] > 0
    yield "older lives are ignored", life == s[r].peer[a]
    heard_from(n, r, a, life)


@PAIR.rule(*BOTH)
def hear_a_new_life_speak(s: State, n: State, r: str, q: str, a: LIFE, life: LIFE) -> Iterator[Need]:
    """A State of a life is heard that was not known (`RobotPair.accept`)."""
    yield "it has heard a roster", acts(s, r, a)
    yield "that life has begun", s[q].born[life] > 0
    yield "the life is new", life > s[r].peer[a]
    talk_with(s, n, r, a, life)
    heard_from(n, r, a, life)


@PAIR.rule(*BOTH)
def turn(s: State, n: State, r: str, q: str, a: LIFE, line: LINE) -> Iterator[Need]:
    """A half-plane towards a place is taken (`Tangent`)."""
    yield "there is a place", every(acts(s, r, a), s[r].stands[a])
    yield "only what the own disk satisfies", fits(r, s[r].ground[a], line)
    yield "only with the place behind it", fits(q, s[r].spot[a], line)
    n[r].clear[a], n[r].tangent[a] = True, line


@PAIR.rule(*EITHER)
def keep_to_the_roster(s: State, n: State, r: str, a: LIFE) -> Iterator[Need]:
    """From this Command on a life keeps to all that the roster says (`Robot.command`)."""
    me = s[r].at(a)
    yield "it has heard a roster", acts(s, r, a)
    yield "it keeps off places where a disk is to appear", implies(every(me.excused, me.stands), me.clear)
    n[r].keeps[a] = me.known


@PAIR.rule(*EITHER)
def move(s: State, n: State, r: str, disk: DISK, body: DISK) -> Iterator[Need]:
    """A Command of the present life is executed; or the robot takes itself for a disk of another size."""
    a = s[r].life
    me = s[r].at(a)
    yield "only commands of a life that is not over", s[r].status == LIVE
    yield "only once it has heard a roster", acts(s, r, a)
    yield "only with something between it and the peer", ready(s, r, a)
    yield (
        "it keeps to its lines",
        s.everywhere(NUMBER, lambda k: implies(obeys(s, a, k), left(disk, s.o.line[a, k])))
        if r == OWNER
        else implies(s.f.holds[a], right(disk, held_line(s, a))),
    )
    yield "it keeps to its tangent", implies(every(me.stands, me.clear), fits(r, disk, me.tangent))
    yield "the body is no larger", inside(body, disk)
    n[r].disk, n[r].body, n[r].ground[a], n[r].mover = disk, body, disk, a


# -- the line


@PAIR.rule()
def propose(s: State, n: State, a: LIFE, line: LINE) -> Iterator[Need]:
    """An owner offers a line, and obeys it from now on (`Owner.propose`)."""
    yield "only to a life that was heard", every(acts(s, OWNER, a), s.o.talks[a], s.o.met[a])
    yield "only what the own disk satisfies", left(s.o.ground[a], line)
    k = s.o.number[a] + 1
    n.o.number[a], n.o.line[a, k], n.o.to[a, k], n.o.proposed[a, k] = k, line, s.o.peer[a], True


def hears_proposal(s: State, b: Term, a: Term, k: Term) -> Iterator[Need]:
    """A State of the owner's newest life is heard, with a proposal."""
    yield "a State of that life is at hand", every(acts(s, FOLLOWER, b), s.f.talks[b])
    yield "older lives are ignored", s.f.peer[b] == a
    yield "the proposal was made", every(s.o.born[a] > 0, k > 0, k <= s.o.number[a])
    yield "it is for this life", s.o.to[a, k] == b
    yield "each number is answered once", k > s.f.seen[b]


@PAIR.rule()
def adopt(s: State, n: State, b: LIFE, a: LIFE, k: NUMBER) -> Iterator[Need]:
    """A follower takes a line that it is offered, and obeys that one only (`Follower.on_proposal`)."""
    yield from hears_proposal(s, b, a, k)
    yield "only what the own disk satisfies", right(s.f.ground[b], s.o.line[a, k])
    me = n.f.at(b)
    me.seen, me.held, me.linked, me.holds, me.holding_of, me.holding = k, k, True, True, a, k
    me.stands = me.clear = False
    current = s.o.peer[a] == b
    n.o.bound[a] = some(s.o.bound[a], current)
    n.o.witness[a] = pick(current, k, s.o.witness[a])


@PAIR.rule()
def reject(s: State, n: State, b: LIFE, a: LIFE, k: NUMBER) -> Iterator[Need]:
    """A follower never adopts a number that it has passed over (`Follower.on_proposal`)."""
    yield from hears_proposal(s, b, a, k)
    n.f.seen[b] = k


@PAIR.rule()
def answer(s: State, n: State, b: LIFE) -> Iterator[Need]:
    """A follower says which number it obeys, and up to which it has answered."""
    yield "it has heard a roster", acts(s, FOLLOWER, b)
    me = s.f.at(b)
    n.f.said[b, me.peer, me.held, me.seen] = True


def hears_answer(s: State, a: Term, b: Term, held: Term, seen: Term) -> Iterator[Need]:
    """A State of the follower's newest life is heard, with an answer."""
    yield "a State of that life is at hand", every(acts(s, OWNER, a), s.o.talks[a])
    yield "older lives are ignored", s.o.peer[a] == b
    yield "the answer was given, to this life", every(s.f.born[b] > 0, s.f.said[b, a, held, seen])
    yield "only what is news", every(s.o.seen[a] < seen, seen <= s.o.number[a])


@PAIR.rule()
def learn_what_was_adopted(
    s: State, n: State, a: LIFE, b: LIFE, held: NUMBER, seen: NUMBER
) -> Iterator[Need]:
    """An owner learns that one of its proposals is held, and drops the others up to `seen`
    (`Owner.on_answer`)."""
    yield from hears_answer(s, a, b, held, seen)
    yield "that was unanswered", s.o.proposed[a, held]
    me = n.o.at(a)
    me.holds, me.held, me.agreed, me.seen = True, held, True, seen
    me.stands = me.clear = False
    me.inherited = lambda _: False
    me.proposed = lambda k: every(s.o.proposed[a, k], k > seen)
    me.bound, me.witness = True, s.f.holding[b]


@PAIR.rule()
def learn_what_was_rejected(
    s: State, n: State, a: LIFE, b: LIFE, held: NUMBER, seen: NUMBER
) -> Iterator[Need]:
    """An owner learns that the follower holds what it held, and drops what was proposed up to `seen`
    (`Owner.on_answer`)."""
    yield from hears_answer(s, a, b, held, seen)
    yield "that was known", no(s.o.proposed[a, held])
    me = n.o.at(a)
    me.seen = seen
    me.proposed = lambda k: every(s.o.proposed[a, k], k > seen)
