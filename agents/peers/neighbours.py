"""What one robot knows of the others: the newest State heard of each, and the disks that stand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from agents.peers.far import FarPicture
from agents.peers.far_field import NOTHING
from agents.peers.state import Peer, PeerState
from protocol.messages import Member


class Neighbours:
    """Peers as last heard. A State is newer when its incarnation is newer, or its tick within the same
    incarnation.

    Args:
        radii: radius (m) of everybody, by id; it is not changed.
        everybody: whether all are heard until somebody is said to be near; else nobody is.

    Attributes:
        standing: disks that stand, or that will appear in a place kept free, by id.
        picture: where those were who are not heard, and whoever else; none where all are heard.
        far: what all those add to the slice who are not heard.
        radii: as last known.
    """

    def __init__(self, radii: Mapping[int, float], *, everybody: bool = True) -> None:
        self.standing: dict[int, Member] = {}
        self.picture: FarPicture | None = None
        self.far = NOTHING
        self._attends = False  # whether some are not heard
        self._gone: dict[int, int] = {}  # newest incarnation that has left; its States may be late
        self.radii = radii
        self._hears = everybody  # whether anybody is heard yet
        self._states: dict[int, PeerState | None] = dict.fromkeys(radii if everybody else ())

    def state(self, peer: int) -> PeerState | None:
        """The newest State of a peer."""
        return self._states.get(peer)

    def on_state(self, state: PeerState) -> bool:
        """Take over a peer's State if it is news; False when it is not."""
        known = self._states.get(state.robot)
        if known is not None and not is_newer(state, known):
            return False
        if self._gone and state.incarnation <= self._gone.get(state.robot, 0):
            return False
        self._states[state.robot] = state
        if self.standing:
            self._rise(state)
        return True

    def _rise(self, state: PeerState) -> None:
        """A fenced robot whose newer incarnation speaks is no obstacle any more."""
        fenced = self.standing.get(state.robot)
        if fenced is not None and state.incarnation > fenced.incarnation:
            del self.standing[state.robot]

    def on_member(self, member: Member) -> None:
        """Take over what a newer roster says of a peer. One that restarts stands until it speaks."""
        self._meet(member)
        state = self.state(member.robot)
        if state is not None and state.incarnation > member.incarnation:
            return
        if member.status in ("standing", "appearing"):
            self.standing[member.robot] = member
        elif member.status == "live" and self._attends:
            self.standing.pop(member.robot, None)  # it may be too far off to be heard
        elif member.status == "gone":
            self.standing.pop(member.robot, None)
            self._gone[member.robot] = member.incarnation
            self._forget(member.robot)

    def _meet(self, member: Member) -> None:
        """Have a place for a peer that the scenario did not name; its radius is the roster's."""
        if self.radii.get(member.robot) != member.radius:
            self.radii = {**self.radii, member.robot: member.radius}  # the others share the one given
        if self._hears or member.status != "live":
            self._states.setdefault(member.robot)

    def attend(self, near: Iterable[int]) -> None:
        """Know the States of those who are near, and of nobody else."""
        kept = sorted(peer for peer in {*near, *self.standing} if peer in self.radii)
        self._attends = self._hears = True
        self._states = {peer: self._states.get(peer) for peer in kept}

    def _forget(self, peer: int) -> None:
        if peer in self._states:
            self._states[peer] = None

    def heard(self) -> list[PeerState]:
        """The newest States of all who have been heard."""
        return [state for state in self._states.values() if state is not None]

    def moving(self) -> list[PeerState]:
        """The newest States of all who do not stand."""
        if not self.standing:
            return self.heard()
        return [state for state in self.heard() if state.robot not in self.standing]

    def disks(self) -> list[Peer]:
        """Everybody whose place is known. One who stands is an obstacle: that it never arrives must
        not keep the others off their goals."""
        if not self.standing:
            return [state for state in self._states.values() if state is not None and state.placed]
        disks: list[Peer] = []
        for peer, state in self._states.items():
            stood = self._stands_at(peer)
            if stood is not None:
                disks.append(Peer(*stood, self.radii[peer], 0.0))
            elif state is not None and state.placed:
                disks.append(state)
        return disks

    def position(self, peer: int) -> tuple[float, float] | None:
        """Where a peer is, as far as known."""
        stood, state = self._stands_at(peer), self.state(peer)
        if stood is not None:
            return stood
        return None if state is None else state.position

    def _stands_at(self, peer: int) -> tuple[float, float] | None:
        member = self.standing.get(peer)
        return None if member is None else member.position


def is_newer(state: PeerState, known: PeerState) -> bool:
    """Whether `state` is of a newer incarnation than `known`, or of a later tick of the same incarnation."""
    if state.incarnation == known.incarnation:
        return state.tick > known.tick
    return state.incarnation > known.incarnation
