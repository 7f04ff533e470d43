"""The two ends of one pair's line: what each has to obey, whatever is lost, late or repeated.

The lower id owns the line: only it proposes, numbering its proposals. Rules:

- The owner proposes only a line that its own disk satisfies, repeats the newest until it is answered, and
  from the first moment obeys the held line and every unanswered proposal.
- The follower answers each number once: it adopts the line when its own disk satisfies it, and
  from then on obeys that one only; otherwise it rejects it, and never adopts it later.
- An answer (held, seen) says which number the follower obeys and up to which it has answered. The
  owner drops every line up to `seen` other than `held`.
- Before anything is said, the first incarnations of both ends obey the initial line, which both derive from
  the scenario's start positions; the owner knows that the follower's first incarnation holds it. Later
  incarnations have none.
- Nothing is offered to an incarnation that has not been heard: it need not know this one.
- Numbers count within one incarnation of the owner. Whatever names an older incarnation of either end than
  the newest known is ignored; known is what was heard of, and what a roster names. An owner whose follower
  restarted keeps obeying all it obeyed, for the follower may have adopted any of it before it died, until the
  newcomer adopts a fresh line.

Invariant: the line that the follower holds is among those that the owner obeys; an end that has
never had a line in this incarnation stands still. It asks nothing of delay, order or delivery.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import final

from agents.lines.line import Line


@final
class Owner:
    """The end with the lower id, in one incarnation of its robot.

    Args:
        incarnation: own incarnation.
        initial: the line obeyed since the start.
        peer_incarnation: the follower's incarnation that obeys it too.
    """

    def __init__(self, incarnation: int, initial: Line | None = None, peer_incarnation: int = 0) -> None:
        self.incarnation = incarnation
        self.peer_incarnation = peer_incarnation  # newest known of the follower; older ones are ignored
        self.met = False  # whether that one has been heard; only then may it be offered a line
        self.held_number = 0  # number of the line that the follower is known to hold, 0 for none
        self.seen = 0  # highest number known to be answered
        self.number = 0  # of the newest proposal
        self.proposed: dict[int, Line] = {}  # unanswered, by number
        self.agreed = initial is not None  # whether the follower is known to have held a line of this one
        self.held = initial  # what the follower is known to hold
        self._inherited: tuple[Line, ...] = ()  # what an earlier incarnation of the follower may have held

    @property
    def obeyed(self) -> tuple[Line, ...]:
        """All lines that this robot must obey."""
        held = () if self.held is None else (self.held,)
        return (*self._inherited, *held, *self.proposed.values())

    @property
    def linked(self) -> bool:
        """Whether the follower holds a line in its present incarnation, the initial one included."""
        return self.held is not None

    @property
    def newest(self) -> Line | None:
        """The line that the follower will hold if it adopts all it is offered."""
        return next(reversed(self.proposed.values())) if self.proposed else self.held

    @property
    def settled(self) -> bool:
        """Whether it obeys one line, which is not the initial one, and which the follower holds."""
        return self.held is not None and self.number > 0 and not self.proposed

    def accept(self, peer_incarnation: int) -> bool:
        """Hear from an incarnation of the follower; False when it is an old one, to be ignored."""
        self.expect(peer_incarnation)
        if peer_incarnation == self.peer_incarnation:
            self.met = True
        return peer_incarnation == self.peer_incarnation

    def expect(self, peer_incarnation: int) -> None:
        """Ignore incarnations of the follower that are older than this one, which is there."""
        if peer_incarnation > self.peer_incarnation:
            self._begin(peer_incarnation)

    def propose(self, line: Line) -> int:
        """Offer a line that the own disk satisfies now; its number. Obeyed from now on."""
        self.number += 1
        self.proposed[self.number] = line
        return self.number

    def on_answer(self, peer_incarnation: int, incarnation: int, held: int, seen: int) -> bool:
        """Process the follower's answer; True when it is news. It names the incarnations of both ends."""
        if (
            not self.accept(peer_incarnation)
            or incarnation != self.incarnation
            or not self.seen < seen <= self.number
        ):
            return False
        if held in self.proposed:
            self.held, self.held_number = self.proposed[held], held
            self._inherited = ()
            self.agreed = True
        self.seen = seen
        self.proposed = {number: line for number, line in self.proposed.items() if number > seen}
        return True

    def fence(self, incarnation: int) -> None:
        """The follower's `incarnation` is fenced: its disk stands still for ever and replaces all lines."""
        self._begin(incarnation + 1)
        self._inherited = ()
        self.agreed = False

    def _begin(self, peer_incarnation: int) -> None:
        """Talk with this incarnation of the follower from now on."""
        self._inherited = self.obeyed
        self.held, self.held_number = None, 0
        self.proposed = {}
        self.seen = self.number
        self.peer_incarnation, self.met = peer_incarnation, False


@final
class Follower:
    """The end with the higher id, in one incarnation of its robot; arguments as of `Owner`."""

    def __init__(self, incarnation: int, initial: Line | None = None, peer_incarnation: int = 0) -> None:
        self.incarnation = incarnation
        self.peer_incarnation = peer_incarnation  # newest known of the owner; older ones are ignored
        self.linked = initial is not None  # whether the held line is one of the owner's present incarnation
        self.held_number = 0  # number of the held line, 0 when it is not linked, or holds the initial line
        self.seen = 0  # highest number answered
        self._held = initial

    @property
    def obeyed(self) -> tuple[Line, ...]:
        """The line that this robot must obey, if any."""
        return () if self._held is None else (self._held,)

    @property
    def agreed(self) -> bool:
        """Whether it holds a line."""
        return self._held is not None

    @property
    def settled(self) -> bool:
        """Whether it obeys a line."""
        return self._held is not None

    def accept(self, peer_incarnation: int) -> bool:
        """Hear from an incarnation of the owner; False when it is an old one, to be ignored."""
        self.expect(peer_incarnation)
        return peer_incarnation == self.peer_incarnation

    def expect(self, peer_incarnation: int) -> None:
        """Ignore incarnations of the owner that are older than this one, which is there."""
        if peer_incarnation > self.peer_incarnation:
            self.linked = False
            self.held_number = self.seen = 0
            self.peer_incarnation = peer_incarnation

    def on_proposal(
        self, peer_incarnation: int, incarnation: int, number: int, line: Line, fits: Callable[[Line], bool]
    ) -> bool:
        """Process the owner's proposal; True when it was adopted. It names the incarnations of both ends.

        `fits` tells whether the own disk satisfies a line now.
        """
        if not self.accept(peer_incarnation) or incarnation != self.incarnation or number <= self.seen:
            return False
        self.seen = number
        if not fits(line):
            return False
        self._held, self.held_number, self.linked = line, number, True
        return True

    def fence(self, incarnation: int) -> None:
        """The owner's `incarnation` is fenced: its disk stands still for ever and replaces the line."""
        self.expect(incarnation + 1)
        self._held = None
