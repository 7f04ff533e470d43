"""The line of one binding: the protocol between its two ends, each in one life.

Number 0 is the first line, which both obey from the beginning. Whatever is lost, late or repeated, the owner
obeys the line that the follower obeys.
"""

from __future__ import annotations

from typing import Generic

from mypy_extensions import mypyc_attr

from protocol.kernel.records import L, require


@mypyc_attr(allow_interpreted_subclasses=True)
class Owner(Generic[L]):
    """The owner, with the lower id, which proposes lines.

    Args:
        first: the first line.

    Attributes:
        held_number, held: the line that the follower adopted last, as far as the owner knows.
        number: of the newest proposal.
        seen: highest number known to be answered.
        open: proposals not yet answered, by ascending number.
    """

    def __init__(self, first: L) -> None:
        self.held_number, self.held = 0, first
        self.number = self.seen = 0
        self.open: list[tuple[int, L]] = []

    def obeyed(self) -> list[L]:
        """The held line, and every open proposal."""
        return [self.held, *[line for _, line in self.open]]

    def propose(self, line: L, fits: bool) -> None:
        """Propose a line that its own body satisfies, and obey it from now on, beside the others."""
        require(fits, "propose: the body fits the line")
        self.number += 1
        self.open.append((self.number, line))

    def on_answer(self, held: int, seen: int) -> None:
        """Accept an answer: the follower has adopted `held` last, and answered all up to `seen`. The owner
        then obeys that line and the proposals after `seen`. Only an answer with a higher `seen` is accepted.
        """
        require(seen > self.seen, "read answer: it has seen more than any before")
        require(seen <= self.number, "read answer: it has seen what was proposed")
        for number, line in self.open:
            if number == held:
                self.held = line
        self.held_number, self.seen = held, seen
        self.open = [each for each in self.open if each[0] > seen]


@mypyc_attr(allow_interpreted_subclasses=True)
class Follower(Generic[L]):
    """The follower, with the higher id, which answers each proposal once.

    Args:
        first: the first line.

    Attributes:
        held_number, held: the line adopted last, the only one that it obeys.
        seen: highest number answered.
    """

    def __init__(self, first: L) -> None:
        self.held_number, self.held = 0, first
        self.seen = 0

    def obeyed(self) -> list[L]:
        """The held line."""
        return [self.held]

    def on_proposal(self, number: int, line: L, fits: bool) -> None:
        """Adopt a line that its own body satisfies, or reject it for good."""
        require(number > self.seen, "adopt: each number is answered once")
        self.seen = number
        if fits:
            self.held_number, self.held = number, line
