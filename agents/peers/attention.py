"""Whose States one robot hears: everybody's, until it is told who is near; of the others it knows the world's
last summary."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final, final

from mypy_extensions import mypyc_attr

from agents.peers.far import FarPicture, Places
from protocol.crowd.interest import LEAD

_EARLY: Final = 8  # summaries that are kept until they are due: more wait after a long pause only


@final
@mypyc_attr(acyclic=True)
class Attention:
    """Sender and tick of a State alone decide whether it is heard, never when it arrives; its tick alone
    decides when a summary is taken in.

    Args:
        turn: ticks after LEAD in which a summary is taken in.
        lockstep: whether others wait for this robot. Where nobody does, a tick that it misses is no pause.

    Attributes:
        everybody: whether all are heard: nobody has said who is near.
        near: whom this robot hears in the present tick, ascending.
        due: tick whose summary has to be there in the present tick; -1 for none.
    """

    __slots__ = (
        "_absent",
        "_arrived",
        "_coming",
        "_due",
        "_from",
        "_gaps",
        "_lockstep",
        "_picture",
        "_present",
        "_since",
        "_take",
        "_turn",
        "due",
        "everybody",
        "near",
    )

    def __init__(self, turn: int = 0, *, lockstep: bool = True) -> None:
        self._lockstep = lockstep
        self.everybody = True
        self.near: tuple[int, ...] = ()
        self.due = self._due = -1
        self._present = -1  # newest tick in which this life took part
        self._absent = -1  # newest before it in which it did not
        self._gaps: list[range] = []  # all of those
        self._turn, self._take = turn, 0  # from that tick on, the summary of `_due` has to be there
        self._since: dict[int, int] = {}  # first tick of whose States count, by peer that is near
        self._coming: tuple[int, ...] | None = None
        self._from = 0  # tick from which those count
        self._arrived: dict[int, Places] = {}  # summaries, by tick
        self._picture: FarPicture | None = None  # taken in last

    def announce(self, tick: int, near: Iterable[int], *, summed_up: bool) -> None:
        """In `tick` the world says who will be near; `summed_up` if its summary is of that tick, too."""
        self.everybody = False
        self._coming, self._from = tuple(sorted(near)), tick + LEAD
        if summed_up:
            self._due, self._take = tick, tick + LEAD + self._turn

    def turn(self, tick: int) -> bool:
        """A tick begins; whether others are near from here on."""
        if self._lockstep and tick > self._present + 1:
            self._gaps.append(range(self._present + 1, tick))  # as many as a scenario has pauses, at most
            self._absent = tick - 1
        self._present = tick
        if tick >= self._take and self.due != self._due:
            self.due = self._due
            self._arrived = {each: self._arrived[each] for each in self._arrived if each >= self.due}
        if self._coming is None or tick < self._from:
            return False
        self.near, self._coming = self._coming, None
        self._since = {peer: self._since.get(peer, self._from) for peer in self.near}
        return True

    def counts(self, peer: int, tick: int) -> bool:
        """Whether a State of `tick` is heard in the present one. In lock-step nobody hears what was said in a
        tick in which they took no part, be it before their life or during a pause: nobody waited until they
        had it, so that when it arrives is a matter of the wall clock."""
        if tick <= self._absent and any(tick in gap for gap in self._gaps):
            return False
        return self.everybody or tick >= self._since.get(peer, tick + 1)

    def on_summary(self, places: Places) -> None:
        """The world says where everybody is, for a tick that begins soon."""
        if places.tick <= self._taken or places.tick < self.due:
            return
        self._arrived[places.tick] = places
        if len(self._arrived) > _EARLY:
            del self._arrived[sorted(self._arrived)[-2]]  # the oldest may be due, and the newest is soon

    @property
    def has_summary(self) -> bool:
        """Whether the summary that is due in this tick has arrived, if one is; or a later one."""
        return self.due < 0 or self._taken >= self.due or max(self._arrived, default=-1) >= self.due

    @property
    def _taken(self) -> int:
        """Tick of the summary that was taken in last."""
        return -1 if self._picture is None else self._picture.tick

    def new_picture(self, radii: Mapping[int, float]) -> FarPicture | None:
        """The summary that is due, once for each.

        Args:
            radii: of all robots, m.
        """
        if self.due <= self._taken:
            return None
        coming = sorted([tick for tick in self._arrived if tick >= self.due])
        if not coming:
            return None
        self._picture = FarPicture(self._arrived[coming[0]], radii, self._picture)
        self._arrived = {tick: self._arrived[tick] for tick in coming[1:]}
        return self._picture
