"""The line of one binding: its two ends, each in one life.

Number 0 is the first line; both obey it from the beginning. Whatever is lost, late or repeated, the line that
the follower obeys is one that the owner obeys.
"""

from __future__ import annotations

from typing import Generic

from mypy_extensions import mypyc_attr

from protocol.kernel.records import L, require


@mypyc_attr(allow_interpreted_subclasses=True)
class Owner(Generic[L]):
    """The low end: it alone proposes.

    Args:
        first: the first line.

    Attributes:
        held_number, held: the line that the follower is known to have adopted last.
        number: of the newest proposal.
        seen: up to which proposals are known to be answered.
        open: the others, by number, ascending.
    """

    def __init__(self, first: L) -> None:
        self.held_number, self.held = 0, first
        self.number = self.seen = 0
        self.open: list[tuple[int, L]] = []

    def obeyed(self) -> list[L]:
        """The line held, and every open proposal."""
        return [self.held, *[line for _, line in self.open]]

    def propose(self, line: L, fits: bool) -> None:
        """Offer a line that the own body fits, and obey it from now on beside what was obeyed before."""
        require(fits, "propose: the body fits the line")
        self.number += 1
        self.open.append((self.number, line))

    def on_answer(self, held: int, seen: int) -> None:
        """The follower has adopted `held` last, and answered all up to `seen`: obey that, and what was
        proposed after `seen`. Only an answer that has seen more than any before is read."""
        require(seen > self.seen, "read answer: it has seen more than any before")
        require(seen <= self.number, "read answer: it has seen what was proposed")
        for number, line in self.open:
            if number == held:
                self.held = line
        self.held_number, self.seen = held, seen
        self.open = [each for each in self.open if each[0] > seen]


@mypyc_attr(allow_interpreted_subclasses=True)
class Follower(Generic[L]):
    """The high end: it answers each number once.

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
        """The line held."""
        return [self.held]

    def on_proposal(self, number: int, line: L, fits: bool) -> None:
        """Adopt a line that the own body fits, or never."""
        require(number > self.seen, "adopt: each number is answered once")
        self.seen = number
        if fits:
            self.held_number, self.held = number, line
