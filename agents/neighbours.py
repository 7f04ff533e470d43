"""What one robot knows of the others: the newest State heard of each, and the disks that stand for good."""

from __future__ import annotations

from collections.abc import Iterable

from protocol.messages import Down, State


class Neighbours:
    """Peers as last heard. A State is newer when its life is newer, or its tick within the same life."""

    def __init__(self, peers: Iterable[int]) -> None:
        self.states: dict[int, State] = {}
        self.down: dict[int, Down] = {}
        self._peers = frozenset(peers)

    def knows(self, robot: int) -> bool:
        """Whether this id is a peer at all."""
        return robot in self._peers

    def hear(self, state: State) -> bool:
        """Take over a peer's State if it is news; False when it is not."""
        known = self.states.get(state.robot)
        if known is not None and (known.incarnation, known.tick) >= (state.incarnation, state.tick):
            return False
        self.states[state.robot] = state
        fenced = self.down.get(state.robot)
        if fenced is not None and state.incarnation > fenced.incarnation:
            del self.down[state.robot]
        return True

    def fence(self, downs: Iterable[Down]) -> list[Down]:
        """Take over the world's list of fenced robots; returns those that are news."""
        news = [down for down in downs if self._is_news(down)]
        for down in news:
            self.down[down.robot] = down
        return news

    def _is_news(self, down: Down) -> bool:
        state, fenced = self.states.get(down.robot), self.down.get(down.robot)
        risen = state is not None and state.incarnation > down.incarnation
        known = fenced is not None and fenced.incarnation >= down.incarnation
        return not (risen or known)

    def position(self, peer: int) -> tuple[float, float] | None:
        """Where a peer is, as far as known; exact for a fenced one."""
        fenced = self.down.get(peer)
        if fenced is not None:
            return fenced.position
        state = self.states.get(peer)
        return None if state is None else state.position
