"""The diagram of docs/concepts/states.md shows what a pair of robots goes through: no more, and no less."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from functools import partial
from typing import Any

from agents.lines.ends import Owner
from agents.lines.line import Line
from agents.lines.own_set import OwnSet
from agents.lines.robot_pair import RobotPair
from agents.peers.state import PeerState
from protocol.messages import Member, Status
from tests.docs.drawn import Transition, drawn, made

PEER, RADIUS = 9, 0.1
LIVES, PROPOSALS = (1, 2), (1, 2)  # of the peer; numbers of the owner's
FAR, NEAR = 1.0, 0.15  # m: where the peer's disk may stand; the own one is not clear of NEAR
AWAY = -2.0  # m: from here it is
FOLLOWING: dict[Status, list[tuple[Status, float | None, int]]] = {
    "live": [("standing", FAR, 0), ("standing", NEAR, 0)],
    "standing": [("live", None, 1), ("gone", None, 0)],
    "gone": [("appearing", FAR, 0), ("appearing", NEAR, 0)],
    "appearing": [("standing", None, 0), ("gone", None, 0)],
}  # what the roster says next: where the disk is (None: as before), and how many lives more


class Pair:
    """One robot's side of a pair, and what the roster says of the peer, which it may not have been told.

    Distances are along the line between the two, from the robot to the peer.
    """

    def __init__(self, owns: bool, founding: bool) -> None:
        self._ahead = 1.0 if owns else -1.0
        initial = Line(1.0, 0.0, 0.5 * self._ahead) if founding else None
        self.pair = RobotPair(
            PEER,
            1,
            owns=owns,
            own_radius=RADIUS,
            radius=RADIUS,
            initial=initial,
            peer_incarnation=1 if founding else 0,
        )
        self._status: Status = "live"
        self._life, self._place, self._own = 1, FAR, 0.0
        self._told, self._tick = founding, 0

    @property
    def state(self) -> str:
        pair = self.pair
        if pair.excused:
            return "Excused"
        if pair.disk is not None:
            return "Clear" if pair.keeps_clear else "InTheWay"
        if not pair.end.agreed:
            return "NoLine"
        return "Settled" if pair.settled else "Open"

    @property
    def key(self) -> Hashable:
        pair, end = self.pair, self.pair.end
        told = (self._status, self._life, self._place, self._told, self._own)
        known = (self.state, pair.heard, pair.state is None, pair.disk is None, pair.keeps_clear)
        said = (end.peer_incarnation, end.held_number, end.seen, end.linked, end.agreed, len(end.obeyed))
        return told, known, said, (end.met, end.number, *end.proposed) if isinstance(end, Owner) else ()

    def events(self) -> Iterator[tuple[Any, ...]]:
        lives = [life for life in LIVES if life <= self._life]
        yield from (("accept", life) for life in lives)
        for life in lives:
            yield from ((*event[:1], life, *event[1:]) for event in self._words())
        if isinstance(end := self.pair.end, Owner) and end.met and end.number < len(PROPOSALS):
            yield ("propose",)
        if not self._told:
            yield ("on_member",)
        for status, place, more in FOLLOWING[self._status]:
            if self._life + more in LIVES:
                yield "roster", status, place or self._place, more
        yield "locate", AWAY - self._own

    def _words(self) -> list[tuple[Any, ...]]:
        """What the peer may say of the line."""
        if not isinstance(self.pair.end, Owner):
            return [("on_proposal", number, fits) for number in PROPOSALS for fits in (True, False)]
        answered = range(1, self.pair.end.number + 1)
        return [("on_answer", held, seen) for seen in answered for held in range(seen + 1)]

    def do(self, event: tuple[Any, ...]) -> Iterator[str]:
        pair, end = self.pair, self.pair.end
        name, *what = event
        if name in ("accept", "on_proposal", "on_answer"):
            accepted = pair.accept(self._state(what[0]))
            yield "accept"
            if accepted and name != "accept" and self._said(*what):
                pair.renew()
            yield name
        elif name == "propose":
            assert isinstance(end, Owner)
            end.propose(Line(1.0, 0.0, 0.4 + 0.1 * end.number))
            pair.renew()
            yield name
        elif name == "on_member":
            pair.on_member(self._member)
            self._told = True
            self._renew()
            yield self._status
        elif name == "roster":
            self._status, self._place, more = what
            self._life, self._told = self._life + more, False
            yield name
        else:
            self._own = what[0]
            self._renew()
            yield "renew"

    def _said(self, life: int, *what: Any) -> bool:
        """The peer's life said something of the line; whether it is another one then."""
        end = self.pair.end
        if isinstance(end, Owner):
            return end.on_answer(life, 1, *what)
        number, fits = what
        return end.on_proposal(life, 1, number, Line(1.0, 0.0, -0.5), lambda _: bool(fits))

    def _state(self, life: int) -> PeerState:
        self._tick += 1
        numbers = (self._ahead * FAR, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        return PeerState(PEER, life, self._tick, True, *numbers, radius=RADIUS)

    @property
    def _member(self) -> Member:
        there = self._status in ("standing", "appearing")
        place = (self._ahead * self._place, 0.0) if there else None
        return Member(PEER, self._life, self._status, RADIUS, place)

    def _renew(self) -> None:
        """As a robot does in every tick."""
        if self.pair.disk is not None:
            self.pair.disk.renew(OwnSet(self._ahead * self._own, 0.0, 0.0))


def test_a_pair_goes_through_what_is_drawn() -> None:
    beginnings: set[Transition] = {
        ("[*]", "both founding", Pair(owns=True, founding=True).state),
        ("[*]", "both founding", Pair(owns=False, founding=True).state),
        ("[*]", "either is a newcomer", Pair(owns=True, founding=False).state),
    }
    begin = [partial(Pair, owns, founding) for owns in (True, False) for founding in (True, False)]
    assert set().union(beginnings, *(made(each, 7) for each in begin)) == drawn("pair")
