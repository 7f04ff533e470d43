"""What holds of a pair in every reachable state: the invariant, a conjunct at a time.

`two_disks_are_apart` is what is wanted; the others carry it. Each has its sentence. "The present life" of a
robot is the one that the coordinator admitted last.
"""

from __future__ import annotations

from tests.proof.engine.logic import Term, every, implies, no, some
from tests.proof.engine.state import State
from tests.proof.pair.model import (
    ANNOUNCED,
    BOTH,
    EITHER,
    FOLLOWER,
    GONE,
    LIFE,
    LIVE,
    NUMBER,
    OWNER,
    PAIR,
    STATIC,
    VERSION,
    acts,
    agreed,
    apart,
    fits,
    held_line,
    inside,
    left,
    obeys,
    present,
    right,
)


@PAIR.conjunct()
def two_disks_are_apart(s: State) -> Term:
    """Two disks that are in the workspace do not overlap."""
    return implies(every(present(s, OWNER), present(s, FOLLOWER)), apart(s.o.disk, s.f.disk))


@PAIR.conjunct(*EITHER)
def no_body_is_larger(s: State, r: str) -> Term:
    """A disk is no larger than the one that its robot takes itself for."""
    return implies(present(s, r), inside(s[r].body, s[r].disk))


# -- the roster


@PAIR.conjunct(*EITHER)
def newest_version(s: State, r: str) -> Term:
    """The newest version says what the coordinator has decided."""
    v, me = s.version, s[r]
    return every(v > 0, me.was_life[v] == me.life, me.was_status[v] == me.status, me.was_place[v] == me.place)


@PAIR.conjunct(*EITHER)
def statuses(s: State, r: str, v: VERSION) -> Term:
    """A robot is gone, announced, static or live, and has no life before its first."""
    me = s[r]
    return every(
        me.was_status[v] >= GONE,
        me.was_status[v] <= LIVE,
        me.was_life[v] >= 0,
        implies(me.was_status[v] == LIVE, me.was_life[v] > 0),
    )


@PAIR.conjunct(*EITHER)
def lives_are_numbered_upwards(s: State, r: str, v: VERSION, w: VERSION) -> Term:
    """A later version never names an older life."""
    return implies(every(v <= w, w <= s.version), s[r].was_life[v] <= s[r].was_life[w])


@PAIR.conjunct(*EITHER)
def a_life_ends_for_good(s: State, r: str, v: VERSION, w: VERSION) -> Term:
    """A life that a version does not call live is not live in any later one."""
    me = s[r]
    return implies(
        every(v <= w, w <= s.version, me.was_life[v] == me.was_life[w], me.was_status[v] != LIVE),
        me.was_status[w] != LIVE,
    )


@PAIR.conjunct(*EITHER)
def lives_are_admitted(s: State, r: str, a: LIFE) -> Term:
    """A life begins with a version, which names it, and is not newer than the present one."""
    me = s[r]
    return implies(
        me.born[a] > 0,
        every(a > 0, a <= me.life, me.born[a] <= s.version, me.was_life[me.born[a]] == a),
    )


@PAIR.conjunct(*EITHER)
def nothing_is_named_early(s: State, r: str, a: LIFE, v: VERSION) -> Term:
    """No version from before a life began names it, or a newer one."""
    return implies(every(s[r].born[a] > 0, v < s[r].born[a]), s[r].was_life[v] < a)


@PAIR.conjunct(*EITHER)
def what_is_named_was_born(s: State, r: str, v: VERSION) -> Term:
    """A life that a version calls live began with that version, or before."""
    me = s[r]
    return implies(
        every(v <= s.version, me.was_status[v] == LIVE),
        every(me.born[me.was_life[v]] > 0, me.born[me.was_life[v]] <= v),
    )


@PAIR.conjunct(*EITHER)
def what_is_static_is_where_it_is_said(s: State, r: str) -> Term:
    """A static disk lies within the place that the roster states."""
    return implies(s[r].status == STATIC, every(inside(s[r].disk, s[r].place), inside(s[r].body, s[r].place)))


@PAIR.conjunct(*EITHER)
def a_static_robot_is_no_larger(s: State, r: str) -> Term:
    """What is static is the body itself."""
    return implies(s[r].status == STATIC, inside(s[r].disk, s[r].body))


@PAIR.conjunct(*EITHER)
def ground_of_the_living(s: State, r: str) -> Term:
    """The disk of a life that is not over is where that life has it."""
    return implies(s[r].status == LIVE, s[r].ground[s[r].life] == s[r].disk)


@PAIR.conjunct(*EITHER)
def acknowledgements(s: State, r: str) -> Term:
    """What the coordinator takes for acknowledged was, by a life that had begun."""
    me = s[r]
    return every(
        me.kept >= 0,
        me.kept_life <= me.life,
        implies(me.kept > 0, every(me.born[me.kept_life] > 0, me.kept <= me.keeps[me.kept_life])),
    )


# -- what was not moved is where it was


@PAIR.conjunct(*EITHER)
def movers(s: State, r: str) -> Term:
    """The disk was moved last by a life that had begun."""
    me = s[r]
    return every(
        me.since >= 0,
        me.mover >= 0,
        me.mover <= me.life,
        implies(me.mover > 0, me.born[me.mover] > 0),
        me.since <= s.version,
    )


@PAIR.conjunct(*EITHER)
def put_in_place(s: State, r: str, v: VERSION) -> Term:
    """Since its place was announced, a disk that is there was announced, static or live."""
    me = s[r]
    return implies(every(present(s, r), v > me.since, v <= s.version), me.was_status[v] >= STATIC)


@PAIR.conjunct(*EITHER)
def announced_first(s: State, r: str) -> Term:
    """A disk that is there was not when its place was announced, or before the run began."""
    me = s[r]
    return implies(present(s, r), me.was_status[me.since] <= ANNOUNCED)


@PAIR.conjunct(*EITHER)
def unmoved_places(s: State, r: str, v: VERSION) -> Term:
    """A disk that no life has moved since is where a version said."""
    me = s[r]
    return implies(
        every(
            present(s, r),
            v > 0,
            v >= me.since,
            v <= s.version,
            me.was_status[v] != LIVE,
            me.was_status[v] != GONE,
            me.was_life[v] >= me.mover,
        ),
        inside(s[r].disk, me.was_place[v]),
    )


@PAIR.conjunct(*EITHER)
def unmoved_grounds(s: State, r: str, a: LIFE) -> Term:
    """And where a life left it that began since."""
    me = s[r]
    return implies(
        every(present(s, r), me.born[a] > me.since, a >= me.mover),
        inside(s[r].disk, me.ground[a]),
    )


# -- what a life knows of the roster


@PAIR.conjunct(*EITHER)
def what_is_known(s: State, r: str, a: LIFE) -> Term:
    """A life has heard a roster only since it began, and while no newer life had."""
    me = s[r]
    return implies(
        me.born[a] > 0,
        every(
            me.known[a] >= 0,
            me.keeps[a] <= me.known[a],
            implies(
                me.known[a] > 0,
                every(me.born[a] <= me.known[a], me.known[a] <= s.version, me.was_life[me.known[a]] == a),
            ),
        ),
    )


@PAIR.conjunct(*EITHER)
def knows_nothing_yet(s: State, r: str, a: LIFE) -> Term:
    """A life that has heard no roster has heard nothing."""
    me = s[r]
    return implies(
        every(me.born[a] > 0, me.known[a] == 0),
        every(me.heard[a] == 0, no(me.stands[a]), no(me.excused[a]), no(me.talks[a])),
    )


@PAIR.conjunct(*BOTH)
def known_places(s: State, r: str, q: str, a: LIFE) -> Term:
    """What a life keeps off is what its roster says, unless it has heard a newer life of the peer."""
    me, v = s[r], s[r].known[a]
    status = s[q].was_status[v]
    return implies(
        every(acts(s, r, a), me.heard[a] <= s[q].was_life[v], status != LIVE),
        every(
            me.stands[a] == (status != GONE),
            me.excused[a] == (status != STATIC),
            implies(me.stands[a], me.spot[a] == s[q].was_place[v]),
        ),
    )


@PAIR.conjunct(*BOTH)
def known_lives(s: State, r: str, q: str, a: LIFE) -> Term:
    """It ignores lives of the peer that are older than the one that its roster names, and that one too if it
    is over."""
    me, v = s[r], s[r].known[a]
    return implies(
        acts(s, r, a),
        every(
            me.peer[a] >= s[q].was_life[v],
            implies(s[q].was_status[v] != LIVE, me.peer[a] > s[q].was_life[v]),
        ),
    )


@PAIR.conjunct(*BOTH)
def known_lives_exist(s: State, r: str, q: str, a: LIFE) -> Term:
    """The newest life that it knows of is none that is to come, unless all up to the present one are over."""
    me = s[r]
    return implies(
        me.born[a] > 0,
        every(
            me.peer[a] >= me.heard[a],
            me.heard[a] <= s[q].life,
            me.heard[a] >= 0,
            me.peer[a] <= s[q].life + 1,
            implies(s[q].status == LIVE, me.peer[a] <= s[q].life),
        ),
    )


@PAIR.conjunct(*EITHER)
def who_talks(s: State, r: str, a: LIFE) -> Term:
    """A State at hand is of the newest life of the peer that is known, which is there."""
    me = s[r]
    return implies(
        every(me.born[a] > 0, me.talks[a]),
        every(me.heard[a] == me.peer[a], no(me.excused[a]), me.known[a] > 0),
    )


@PAIR.conjunct(*EITHER)
def who_is_excused(s: State, r: str, a: LIFE) -> Term:
    """A peer that is not there, as far as is known, has not been heard since, and is behind no line."""
    me = s[r]
    return implies(
        every(me.born[a] > 0, me.excused[a]),
        every(me.heard[a] < me.peer[a], no(s.o.bound[a] if r == OWNER else s.f.holds[a])),
    )


@PAIR.conjunct(*EITHER)
def a_line_replaces_the_place(s: State, r: str, a: LIFE) -> Term:
    """A life that has agreed on a line keeps off no place, and takes the peer for present."""
    me = s[r]
    return implies(every(me.born[a] > 0, agreed(s, r, a)), every(no(me.stands[a]), no(me.excused[a])))


@PAIR.conjunct(*BOTH)
def tangents(s: State, r: str, q: str, a: LIFE) -> Term:
    """A half-plane towards a place has the own disk on this side, and the place on the other."""
    me = s[r]
    return implies(
        every(me.born[a] > 0, me.stands[a], me.clear[a]),
        every(fits(r, me.ground[a], me.tangent[a]), fits(q, me.spot[a], me.tangent[a])),
    )


@PAIR.conjunct(*BOTH)
def clear_of_what_is_announced(s: State, r: str, q: str) -> Term:
    """A live robot that has acknowledged the present version keeps off a place that it announces."""
    me, a = s[r], s[r].life
    return implies(
        every(me.status == LIVE, me.keeps[a] == s.version, s[q].status == ANNOUNCED),
        every(me.stands[a], me.clear[a], me.spot[a] == s[q].place, me.excused[a]),
    )


@PAIR.conjunct(*BOTH)
def excused_and_there(s: State, r: str, q: str) -> Term:
    """A live robot that takes a disk for absent that has appeared meanwhile keeps off the place."""
    me, a = s[r], s[r].life
    return implies(
        every(me.status == LIVE, present(s, q), me.known[a] > 0, me.excused[a]),
        every(me.stands[a], me.clear[a]),
    )


@PAIR.conjunct(*BOTH)
def knows_what_appeared(s: State, r: str, q: str) -> Term:
    """A live robot knows that the peer's place was announced, or began later."""
    me, a = s[r], s[r].life
    return implies(
        every(me.status == LIVE, present(s, q)),
        some(me.known[a] >= s[q].since, me.born[a] > s[q].since),
    )


@PAIR.conjunct(*BOTH)
def no_place_of_the_living(s: State, r: str, q: str) -> Term:
    """Of a peer's present life that is live and no newer than the own one, no place is known."""
    me, a, b = s[r], s[r].life, s[q].life
    return implies(
        every(me.status == LIVE, me.born[a] >= s[q].born[b], s[q].status == LIVE),
        every(no(me.stands[a]), no(me.excused[a])),
    )


@PAIR.conjunct(*BOTH)
def places_are_where_disks_are(s: State, r: str, q: str) -> Term:
    """A live robot that keeps off a place keeps off the disk that is there, unless they have a line."""
    me, a = s[r], s[r].life
    line = s.o.bound[a] if r == OWNER else s.f.holds[a]
    return implies(
        every(me.status == LIVE, me.known[a] > 0, present(s, q), me.stands[a], no(line)),
        inside(s[q].disk, me.spot[a]),
    )


@PAIR.conjunct(*BOTH)
def who_moved_was_heard(s: State, r: str, q: str) -> Term:
    """A live robot has heard the life of the peer that moved, if that one began later."""
    me, a, b = s[r], s[r].life, s[q].mover
    return implies(
        every(me.status == LIVE, b > 0, present(s, q), s[q].born[b] > me.born[a], s[q].born[b] > s[q].since),
        me.heard[a] >= b,
    )


@PAIR.conjunct(*BOTH)
def who_moved_is_known(s: State, r: str, q: str) -> Term:
    """A live robot ignores only lives of the peer that moved its disk no later than one that counts."""
    me, a = s[r], s[r].life
    return implies(every(me.status == LIVE, me.known[a] > 0, present(s, q)), s[q].mover <= me.peer[a])


@PAIR.conjunct(*BOTH)
def ground_of_the_peer(s: State, r: str, q: str) -> Term:
    """The peer's disk is where the life left it that a live robot knows of, or has it."""
    me, b = s[r], s[r].peer[s[r].life]
    return implies(
        every(me.status == LIVE, me.known[me.life] > 0, present(s, q), s[q].born[b] > 0),
        every(inside(s[q].disk, s[q].ground[b]), s[q].born[b] > s[q].since),
    )


# -- the line between two lives


@PAIR.conjunct()
def proposals(s: State, a: LIFE, k: NUMBER) -> Term:
    """Proposals are numbered, and made to lives that were heard."""
    return implies(
        every(s.o.born[a] > 0, k > 0, k <= s.o.number[a]),
        every(s.o.to[a, k] <= s.o.heard[a], s.o.to[a, k] > 0),
    )


@PAIR.conjunct()
def open_proposals(s: State, a: LIFE, k: NUMBER) -> Term:
    """Unanswered are only proposals to the newest life that is known."""
    return implies(
        every(s.o.born[a] > 0, s.o.proposed[a, k]),
        every(k > 0, k <= s.o.number[a], k > s.o.seen[a], s.o.to[a, k] == s.o.peer[a]),
    )


@PAIR.conjunct()
def who_was_met(s: State, a: LIFE) -> Term:
    """The follower's life of which a State is at hand may be offered lines."""
    return implies(every(s.o.born[a] > 0, s.o.talks[a]), s.o.met[a])


@PAIR.conjunct()
def a_held_line_is_alone(s: State, a: LIFE, k: NUMBER) -> Term:
    """An owner whose follower holds a line inherits none."""
    return implies(every(s.o.born[a] > 0, s.o.holds[a]), no(s.o.inherited[a, k]))


@PAIR.conjunct()
def what_is_held_is_agreed(s: State, a: LIFE) -> Term:
    """And has agreed on one."""
    return implies(every(s.o.born[a] > 0, s.o.holds[a]), s.o.agreed[a])


@PAIR.conjunct()
def held_numbers_are_answered(s: State, a: LIFE) -> Term:
    """What the follower is known to hold was answered."""
    return implies(every(s.o.born[a] > 0, s.o.holds[a]), s.o.held[a] <= s.o.seen[a])


@PAIR.conjunct()
def numbers(s: State, a: LIFE) -> Term:
    """Only numbers that were proposed are answered."""
    return implies(s.o.born[a] > 0, every(s.o.seen[a] >= 0, s.o.seen[a] <= s.o.number[a]))


@PAIR.conjunct()
def obeyed_lines(s: State, a: LIFE, k: NUMBER) -> Term:
    """An owner's disk satisfies all that its life obeys."""
    return implies(every(s.o.born[a] > 0, obeys(s, a, k)), left(s.o.ground[a], s.o.line[a, k]))


@PAIR.conjunct()
def obeyed_numbers(s: State, a: LIFE, k: NUMBER) -> Term:
    """Which was proposed, or is the initial line."""
    return implies(every(s.o.born[a] > 0, obeys(s, a, k)), every(k >= 0, k <= s.o.number[a]))


@PAIR.conjunct()
def held_lines(s: State, b: LIFE) -> Term:
    """A follower's disk satisfies the line that its life holds."""
    return implies(every(s.f.born[b] > 0, s.f.holds[b]), right(s.f.ground[b], held_line(s, b)))


@PAIR.conjunct()
def links(s: State, b: LIFE) -> Term:
    """A follower that is linked holds a line of the owner's newest life that it knows."""
    return implies(
        every(s.f.born[b] > 0, s.f.linked[b]),
        every(s.f.holds[b], s.f.holding_of[b] == s.f.peer[b], s.f.held[b] == s.f.holding[b]),
    )


@PAIR.conjunct()
def held_numbers_exist(s: State, b: LIFE) -> Term:
    """What a follower holds was proposed, or is the initial line."""
    a, k = s.f.holding_of[b], s.f.holding[b]
    return implies(
        every(s.f.born[b] > 0, s.f.holds[b]),
        every(some(a == 0, s.o.born[a] > 0), k >= 0, k <= s.o.number[a], a <= s.f.peer[b]),
    )


@PAIR.conjunct()
def nothing_is_numbered_zero(s: State) -> Term:
    """No life is numbered 0, and none proposes as that."""
    return every(s.o.born[0] == 0, s.f.born[0] == 0, s.o.number[0] == 0)


@PAIR.conjunct()
def witnesses(s: State) -> Term:
    """A line that the owner's present life counts on was proposed, or is the initial one."""
    a = s.o.life
    return implies(
        every(s.o.status == LIVE, s.o.bound[a]), every(s.o.witness[a] >= 0, s.o.witness[a] <= s.o.number[a])
    )


@PAIR.conjunct()
def not_linked(s: State, b: LIFE) -> Term:
    """One that is not says that it holds none."""
    return implies(every(s.f.born[b] > 0, no(s.f.linked[b])), s.f.held[b] == 0)


@PAIR.conjunct()
def what_was_answered(s: State, b: LIFE) -> Term:
    """A follower holds no number above those that it has answered."""
    return implies(s.f.born[b] > 0, every(s.f.seen[b] >= s.f.held[b], s.f.held[b] >= 0))


@PAIR.conjunct()
def answered_numbers_exist(s: State, b: LIFE) -> Term:
    """And has answered only numbers of the owner's newest life that it knows."""
    a = s.f.peer[b]
    return implies(
        every(s.f.born[b] > 0, s.f.seen[b] > 0),
        every(s.o.born[a] > 0, s.f.seen[b] <= s.o.number[a]),
    )


@PAIR.conjunct()
def answers(s: State, b: LIFE, a: LIFE, held: NUMBER, seen: NUMBER) -> Term:
    """An answer was true when it was given: since then the follower has adopted only numbers above `seen`."""
    me = s.f
    return implies(
        every(me.born[b] > 0, me.said[b, a, held, seen]),
        every(
            a <= me.peer[b],
            held >= 0,
            held <= seen,
            implies(
                me.peer[b] == a,
                every(
                    seen <= me.seen[b],
                    implies(held > 0, me.linked[b]),
                    some(me.held[b] == held, me.held[b] > seen),
                ),
            ),
        ),
    )


@PAIR.conjunct()
def what_may_be_adopted_is_obeyed(s: State, a: LIFE, b: LIFE, k: NUMBER) -> Term:
    """An owner obeys every proposal that the follower's life it talks with may yet adopt."""
    return implies(
        every(
            s.o.born[a] > 0,
            s.f.born[b] > 0,
            s.o.peer[a] == b,
            k > 0,
            k <= s.o.number[a],
            s.o.to[a, k] == b,
            some(s.f.peer[b] < a, every(s.f.peer[b] == a, k > s.f.seen[b])),
        ),
        s.o.proposed[a, k],
    )


@PAIR.conjunct()
def what_is_held_is_obeyed(s: State, a: LIFE, b: LIFE) -> Term:
    """And the line that this life holds."""
    k = s.f.holding[b]
    return implies(
        every(s.o.born[a] > 0, s.f.born[b] > 0, s.o.peer[a] == b, s.f.linked[b], s.f.peer[b] == a),
        every(
            some(s.o.proposed[a, k], every(s.o.holds[a], s.o.held[a] == k)),
            s.o.bound[a],
            s.o.witness[a] == k,
        ),
    )


@PAIR.conjunct()
def a_link_was_heard(s: State, a: LIFE, b: LIFE) -> Term:
    """An owner knows every life that holds a line of its, and has heard it, but for founding lives."""
    return implies(
        every(s.o.born[a] > 0, s.f.born[b] > 0, s.f.linked[b], s.f.peer[b] == a),
        every(
            s.o.peer[a] >= b,
            implies(s.f.holding[b] == 0, s.f.born[b] == s.o.born[a]),
            implies(
                s.f.holding[b] > 0, every(s.o.to[a, s.f.holding[b]] == b, s.f.holding[b] <= s.o.number[a])
            ),
        ),
    )


@PAIR.conjunct()
def founding_links(s: State, b: LIFE) -> Term:
    """A follower has heard the life that it is linked with, but for a founding one."""
    a = s.f.peer[b]
    return implies(
        every(s.f.born[b] > 0, s.f.linked[b], s.f.heard[b] < a),
        every(s.f.holding[b] == 0, s.o.born[a] > 0, s.o.born[a] <= s.f.born[b]),
    )


@PAIR.conjunct()
def the_follower_is_behind_a_line(s: State) -> Term:
    """The follower's disk is right of a line that the owner's present life obeys, wherever that counts on
    one."""
    a = s.o.life
    return implies(
        every(s.o.status == LIVE, present(s, FOLLOWER), s.o.bound[a]),
        every(obeys(s, a, s.o.witness[a]), right(s.f.disk, s.o.line[a, s.o.witness[a]])),
    )


@PAIR.conjunct()
def an_open_line_that_counts_is_held(s: State) -> Term:
    """If the owner's present life counts on a proposal, the follower's life that it talks with holds that."""
    a, b = s.o.life, s.o.peer[s.o.life]
    return implies(
        every(s.o.status == LIVE, s.o.bound[a], s.o.proposed[a, s.o.witness[a]]),
        every(s.f.linked[b], s.f.peer[b] == a, s.f.holding[b] == s.o.witness[a], s.f.born[b] > 0),
    )


@PAIR.conjunct()
def agreed_is_bound(s: State, a: LIFE) -> Term:
    """An owner that has agreed on a line counts on one."""
    return implies(every(s.o.born[a] > 0, s.o.agreed[a]), s.o.bound[a])


@PAIR.conjunct()
def the_owner_is_behind_a_line(s: State) -> Term:
    """The owner's disk is left of the line that the follower's present life holds."""
    b = s.f.life
    return implies(
        every(s.f.status == LIVE, present(s, OWNER), s.f.holds[b]), left(s.o.disk, held_line(s, b))
    )


@PAIR.conjunct()
def a_later_owner_waits(s: State) -> Term:
    """An owner that began later than the live follower counts on a line only once that follower holds one of
    it."""
    a, b = s.o.life, s.f.life
    return implies(
        every(s.o.status == LIVE, s.f.status == LIVE, s.o.born[a] >= s.f.born[b], s.o.bound[a]),
        every(s.f.linked[b], s.f.peer[b] == a),
    )


@PAIR.conjunct()
def a_later_follower_waits(s: State) -> Term:
    """A follower that began later than the live owner holds a line only of that owner."""
    a, b = s.o.life, s.f.life
    return implies(
        every(s.o.status == LIVE, s.f.status == LIVE, s.f.born[b] >= s.o.born[a], s.f.holds[b]),
        every(s.f.linked[b], s.f.peer[b] == a),
    )
