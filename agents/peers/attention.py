"""Whose States one robot hears: everybody's, until it is told who is near; of the others it knows the world's
last summary."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import final

from mypy_extensions import mypyc_attr

from agents.peers.far import FarPicture
from protocol.interest import LEAD
from protocol.messages import Summary


@final
@mypyc_attr(acyclic=True)
class Attention:
    """Sender and tick of a State alone decide whether it is heard, never when it arrives.

    Args:
        turn: ticks after LEAD in which a summary is taken in.

    Attributes:
        everybody: whether all are heard: nobody has said who is near.
        near: whom this robot hears in the present tick, ascending.
        due: tick whose summary has to be there in the present tick; -1 for none.
    """

    __slots__ = (
        "_coming",
        "_due",
        "_first",
        "_from",
        "_painted",
        "_picture",
        "_since",
        "_take",
        "_turn",
        "due",
        "everybody",
        "near",
    )

    def __init__(self, turn: int = 0) -> None:
        self.everybody = True
        self.near: tuple[int, ...] = ()
        self.due = self._due = -1
        self._first = -1  # the first of this life
        self._turn, self._take = turn, 0  # from that tick on, the summary of `_due` has to be there
        self._since: dict[int, int] = {}  # first tick of whose States count, by peer that is near
        self._coming: tuple[int, ...] | None = None
        self._from = 0  # tick from which those count
        self._picture: FarPicture | None = None  # newest
        self._painted = -1  # tick of the picture that was taken in last

    def announce(self, tick: int, near: Iterable[int], *, summed_up: bool) -> None:
        """In `tick` the world says who will be near; `summed_up` if its summary is of that tick, too."""
        self.everybody = False
        self._coming, self._from = tuple(sorted(near)), tick + LEAD
        if summed_up:
            self._due, self._take = tick, tick + LEAD + self._turn

    def turn(self, tick: int) -> bool:
        """A tick begins; whether others are near from here on."""
        if self._first < 0:
            self._first = tick
        if tick >= self._take:
            self.due = self._due
        if self._coming is None or tick < self._from:
            return False
        self.near, self._coming = self._coming, None
        self._since = {peer: self._since.get(peer, self._from) for peer in self.near}
        return True

    def counts(self, peer: int, tick: int) -> bool:
        """Whether a State of `tick` is heard in the present one. No life hears what was said before it: how
        much of that still arrives is a matter of the wall clock."""
        return tick >= self._first and (self.everybody or tick >= self._since.get(peer, tick + 1))

    def on_summary(self, summary: Summary, radii: Mapping[int, float]) -> None:
        """The world says where everybody is, for a tick that begins soon.

        Args:
            summary: that has arrived.
            radii: of all robots, m.

        Raises:
            MessageError: it is not made as a summary is.
        """
        if self._picture is None or summary.tick > self._picture.tick:
            self._picture = FarPicture(summary, radii, self._picture)

    @property
    def has_summary(self) -> bool:
        """Whether the summary that is due in this tick has arrived, if one is."""
        return self.due < 0 or (self._picture is not None and self._picture.tick >= self.due)

    def new_picture(self) -> FarPicture | None:
        """The newest summary, once for each that is due."""
        picture = self._picture
        if picture is None or not self._painted < self.due <= picture.tick:
            return None
        self._painted = picture.tick
        return picture
