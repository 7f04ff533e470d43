"""What one robot knows of the others: the newest State heard of each, and the disks that stand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from agents.peers.far import FarPicture
from agents.peers.far_field import NOTHING
from agents.peers.state import Peer, PeerState
from protocol.messages import Member


class Neighbours:
    """Peers as last heard. Of each only the life counts that the roster names.

    Args:
        radii: radius (m) of all robots, by id; it is not changed.
        everybody: whether all robots are heard; else one that lives again may be too far off to be heard.

    Attributes:
        members: what the newest roster says of each robot, by id; shared, and not changed.
        standing: disks that stand, or that will appear in a place kept free, by id.
        picture: where those were who are not heard, and whoever else; none where all are heard.
        far: what all those add to the slice who are not heard.
        radii: as last known.
    """

    def __init__(self, radii: Mapping[int, float], *, everybody: bool = True) -> None:
        self.standing: dict[int, Member] = {}
        self.picture: FarPicture | None = None
        self.far = NOTHING
        self.radii = radii
        self._everybody = everybody
        self.members: Mapping[int, Member] = {}
        self._states: dict[int, PeerState | None] = {}

    def state(self, peer: int) -> PeerState | None:
        """The newest State of a peer."""
        return self._states.get(peer)

    def on_state(self, state: PeerState) -> bool:
        """Take over a peer's State if it is news of its present life; False when it is not."""
        known, member, life = self._states.get(state.robot), self.members.get(state.robot), state.incarnation
        if member is not None and (member.incarnation != life or member.status != "live"):
            return False
        if known is not None and not is_newer(state, known):
            return False
        self._states[state.robot] = state
        if self.standing:
            self.standing.pop(state.robot, None)
        return True

    def on_member(self, member: Member) -> None:
        """A newer roster says this of a peer; `members` is that of it. One that restarts stands until it
        speaks."""
        robot = member.robot
        if self.radii.get(robot) != member.radius:
            self.radii = {**self.radii, robot: member.radius}  # the others share the one given
        if member.status in ("standing", "appearing"):
            self.standing[robot] = member
            self._states.setdefault(robot, None)
        elif member.status == "live" and not self._everybody:
            self.standing.pop(robot, None)
        elif member.status == "gone":
            self.standing.pop(robot, None)
            self._states.pop(robot, None)

    def attend(self, heard: Iterable[int]) -> None:
        """Know the States of these, and of no other robot."""
        kept = sorted({*heard, *self.standing})
        if kept != list(self._states):
            self._states = {peer: self._states.get(peer) for peer in kept}

    @property
    def known(self) -> Iterable[int]:
        """Peers whose States are kept, once there are any."""
        return self._states.keys()

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
