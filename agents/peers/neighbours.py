"""What one robot knows of the others: the roster, the newest State heard of each, the disks that stand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, final

from agents.peers.far import NOTHING, FarPicture
from agents.peers.state import Peer, PeerState
from protocol.codec import keeps_newest
from protocol.geometry import Shape
from protocol.messages import Member, PartPlace, PlacedObstacle, Roster
from protocol.scenario.model import RobotSpec


@keeps_newest
def _by_id(members: tuple[Member, ...]) -> Mapping[int, Member]:
    """What robots of one process are told alike is kept once; it is never changed."""
    return {each.robot: each for each in members}


@final
class KnownRoster:
    """The newest roster heard by one life of one robot.

    Args:
        robot: own id.
        listed: shapes of the scenario's obstacles, by number.

    Attributes:
        version: of it; 0 as long as there is none.
        members: every robot that it names, by id, in its order.
        obstacles: that came or went, as it says.
        parts: where each is.
        shapes: of all obstacles that are there, or are to appear.
    """

    def __init__(self, robot: int, listed: Mapping[int, Shape]) -> None:
        self.version = 0
        self.obstacles: tuple[PlacedObstacle, ...] = ()
        self.parts: tuple[PartPlace, ...] = ()
        self._robot, self._listed = robot, listed
        self.members: Mapping[int, Member] = {}
        self.shapes: list[Shape] = list(listed.values())

    def update(self, roster: Roster) -> list[Member]:
        """Take over a roster if it is newer; what it says anew of others, in the order of their ids."""
        if roster.version <= self.version:
            return []
        before, self.members = self.members, _by_id(roster.members)
        if roster.obstacles != self.obstacles:
            shapes = dict(self._listed)
            for obstacle in roster.obstacles:
                shapes.pop(obstacle.number, None)
                if obstacle.status != "gone":
                    shapes[obstacle.number] = obstacle.shape
            self.shapes = list(shapes.values())
        self.version, self.obstacles, self.parts = roster.version, roster.obstacles, roster.parts
        return [
            each
            for each in self.members.values()
            if each.robot != self._robot and before.get(each.robot) != each
        ]

    def member(self, robot: int) -> Member | None:
        """What it says of an id."""
        return self.members.get(robot)


def has_ended(roster: Roster, robot: int, incarnation: int) -> bool:
    """Whether a roster says that this incarnation is over: its disk stands, or a newer incarnation is
    there."""
    for member in roster.members:
        if member.robot == robot and member.incarnation >= incarnation:
            return member.incarnation > incarnation or member.status != "live"
    return False


class FleetRadii(NamedTuple):
    """Who is in it, by id; it is never changed.

    Attributes:
        ids: of all.
        radii: of their disks, m.
    """

    ids: frozenset[int]
    radii: Mapping[int, float]


@keeps_newest
def fleet_of(robots: tuple[RobotSpec, ...]) -> FleetRadii:
    """The fleet of a scenario's robots."""
    radii = {robot.id: robot.radius for robot in robots}
    return FleetRadii(frozenset(radii), radii)


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

    def on_state(self, state: PeerState, tick: int) -> bool:
        """Take over a peer's State in a tick if it is news of its present life; False when it is not."""
        member = self.members.get(state.robot)
        if member is not None and (member.incarnation != state.incarnation or member.status != "live"):
            return False
        if not state.follow(self._states.get(state.robot), tick):
            return False
        self._keep(state.robot, state)
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
            if robot not in self._states:
                self._keep(robot, None)
        elif member.status == "live" and not self._everybody:
            self.standing.pop(robot, None)
        elif member.status == "gone":
            self.standing.pop(robot, None)
            self._states.pop(robot, None)

    def _keep(self, robot: int, state: PeerState | None) -> None:
        """In the order of ids, whatever comes first: sums over peers depend on it in the last bit."""
        if robot in self._states:
            self._states[robot] = state
        else:
            self._states = dict(sorted({**self._states, robot: state}.items()))

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
