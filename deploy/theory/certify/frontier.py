"""Branching that can be stopped and spread: nodes in preorder, with open boxes where work is left.

A depth-first search that stops leaves what it did, followed by the boxes on its stack; put in place of the
box that it began with, they keep the whole in preorder. So any open box can be worked on anywhere, for as
long as it suits, and the result does not depend on where or in which portions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

EMPTY, FALLS = 255, 254  # leaves of the branching; every other byte is the row of the box that was halved


class Open(NamedTuple):
    """A box that is still to be looked at, rows by bounds; it is 2^-level of the whole."""

    box: NDArray[np.float64]
    level: int


class Grown(NamedTuple):
    """What came of a box, in preorder: the nodes that were done, then what is still open."""

    branching: bytes
    rest: list[Open]


@dataclass
class Frontier:
    """kappa: the range of 1/k; parts: finished nodes and open boxes, in preorder."""

    kappa: tuple[float, float]
    parts: list[bytes | Open] = field(default_factory=list)
    nodes: int = 0

    @property
    def open(self) -> list[Open]:
        """Boxes that are still to be looked at, in preorder."""
        return [part for part in self.parts if isinstance(part, Open)]

    @property
    def done(self) -> float:
        """Share of the whole that is done, from 0 to 1, each halving counting a half."""
        return 1.0 - sum(0.5**part.level for part in self.open)

    @property
    def branching(self) -> bytes:
        """One byte a node in preorder; complete when nothing is open."""
        return b"".join(part for part in self.parts if isinstance(part, bytes))

    def put(self, root: Open, grown: Grown) -> None:
        """Replace an open box by what came of it."""
        at = next(n for n, part in enumerate(self.parts) if part is root)
        merged = [*self.parts[:at], grown.branching, *grown.rest, *self.parts[at + 1 :]]
        self.parts = list(_joined(merged))
        self.nodes += len(grown.branching)


def _joined(parts: list[bytes | Open]) -> Iterator[bytes | Open]:
    """The same with neighbouring bytes in one."""
    run = b""
    for part in parts:
        if isinstance(part, bytes):
            run += part
            continue
        if run:
            yield run
        run = b""
        yield part
    if run:
        yield run
