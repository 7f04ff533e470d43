"""What one robot knows of the others: the newest State heard of each, and the disks that stand for good."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from agents.peer_state import PeerState
from agents.slice import Peer
from protocol.messages import Down


class Neighbours:
    """Peers as last heard. A State is newer when its life is newer, or its tick within the same life.

    Args:
        radii: radius (m) of every peer, by id.
    """

    def __init__(self, radii: Mapping[int, float]) -> None:
        self.down: dict[int, Down] = {}
        self._radii = list(radii.items())
        self._place = {peer: place for place, peer in enumerate(radii)}
        self._states: list[PeerState | None] = [None] * len(radii)

    def state(self, peer: int) -> PeerState | None:
        """The newest State of a peer."""
        place = self._place.get(peer)
        return None if place is None else self._states[place]

    def hear(self, state: PeerState) -> bool:
        """Take over a peer's State if it is news; False when it is not."""
        place = state.place
        known = self._states[place]
        if known is None or known.robot != state.robot:
            place = self._place[state.robot]
            known = self._states[place]
        if known is not None and not is_newer(state, known):
            return False
        self._states[place] = state
        if self.down:
            self._rise(state)
        return True

    def _rise(self, state: PeerState) -> None:
        """A fenced robot whose newer life speaks is no obstacle any more."""
        fenced = self.down.get(state.robot)
        if fenced is not None and state.incarnation > fenced.incarnation:
            del self.down[state.robot]

    def fence(self, downs: Iterable[Down]) -> list[Down]:
        """Take over the world's list of fenced robots; returns those that are news."""
        news = [down for down in downs if self._is_news(down)]
        for down in news:
            self.down[down.robot] = down
        return news

    def _is_news(self, down: Down) -> bool:
        state, fenced = self.state(down.robot), self.down.get(down.robot)
        risen = state is not None and state.incarnation > down.incarnation
        known = fenced is not None and fenced.incarnation >= down.incarnation
        return not (risen or known)

    def heard(self) -> list[PeerState]:
        """The newest States of all who have been heard."""
        return [state for state in self._states if state is not None]

    def moving(self) -> list[PeerState]:
        """The newest States of all who are not fenced."""
        if not self.down:
            return self.heard()
        return [state for state in self.heard() if state.robot not in self.down]

    def disks(self) -> list[Peer]:
        """Everybody whose place is known. One who is fenced is an obstacle: that it never arrives must
        not keep the others off their goals."""
        if not self.down:
            return [state for state in self._states if state is not None and state.placed]
        disks: list[Peer] = []
        for (peer, radius), state in zip(self._radii, self._states, strict=True):
            if peer in self.down:
                disks.append(Peer(*self.down[peer].position, radius, 0.0))
            elif state is not None and state.placed:
                disks.append(state)
        return disks

    def position(self, peer: int) -> tuple[float, float] | None:
        """Where a peer is, as far as known; exact for a fenced one."""
        if peer in self.down:
            return self.down[peer].position
        state = self.state(peer)
        return None if state is None else state.position


def is_newer(state: PeerState, known: PeerState) -> bool:
    """Whether `state` is of a newer life than `known`, or of a later tick of the same life."""
    if state.incarnation == known.incarnation:
        return state.tick > known.tick
    return state.incarnation > known.incarnation
