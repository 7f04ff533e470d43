"""What one robot knows of the others: the newest State heard of each, and the disks that stand for good."""

from __future__ import annotations

from collections.abc import Iterable

from agents.peer_state import PeerState
from protocol.messages import Down


class Neighbours:
    """Peers as last heard. A State is newer when its life is newer, or its tick within the same life."""

    def __init__(self, peers: Iterable[int]) -> None:
        self.states: dict[int, PeerState] = {}
        self.down: dict[int, Down] = {}
        self._peers = frozenset(peers)

    def knows(self, robot: int) -> bool:
        """Whether this id is a peer at all."""
        return robot in self._peers

    def hear(self, state: PeerState) -> bool:
        """Take over a peer's State if it is news; False when it is not."""
        robot = state.robot
        known = self.states.get(robot)
        if known is not None and not is_newer(state, known):
            return False
        self.states[robot] = state
        if robot in self.down and state.incarnation > self.down[robot].incarnation:
            del self.down[robot]
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

    def moving(self) -> list[PeerState]:
        """The newest States of all who are not fenced."""
        if not self.down:
            return list(self.states.values())
        return [state for peer, state in self.states.items() if peer not in self.down]

    def position(self, peer: int) -> tuple[float, float] | None:
        """Where a peer is, as far as known; exact for a fenced one."""
        if peer in self.down:
            return self.down[peer].position
        state = self.states.get(peer)
        return None if state is None else state.position


def is_newer(state: PeerState, known: PeerState) -> bool:
    """Whether `state` is of a newer life than `known`, or of a later tick of the same life."""
    if state.incarnation == known.incarnation:
        return state.tick > known.tick
    return state.incarnation > known.incarnation
