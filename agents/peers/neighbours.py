"""A robot's peers: the roster, the newest State received from each, and the static disks."""

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
    return {each.robot: each for each in members}


@final
class KnownRoster:
    """The newest roster received by one life of one robot.

    Args:
        robot: own id.
        listed: shapes of the scenario's obstacles, by number.

    Attributes:
        version: of the roster; 0 before the first.
        members: its entries, by id, in its order.
        obstacles: its obstacles that appeared or were removed.
        parts: the place of each part.
        shapes: of all obstacles that are present or appearing.
    """

    def __init__(self, robot: int, listed: Mapping[int, Shape]) -> None:
        self.version = 0
        self.obstacles: tuple[PlacedObstacle, ...] = ()
        self.parts: tuple[PartPlace, ...] = ()
        self._robot, self._listed = robot, listed
        self.members: Mapping[int, Member] = {}
        self.shapes = tuple(listed.values())

    def update(self, roster: Roster) -> list[Member]:
        """Adopt a roster if it is newer; returns the entries of peers that changed, by id."""
        if roster.version <= self.version:
            return []
        before, self.members = self.members, _by_id(roster.members)
        if roster.obstacles != self.obstacles:
            shapes = dict(self._listed)
            for obstacle in roster.obstacles:
                shapes.pop(obstacle.number, None)
                if obstacle.status != "gone":
                    shapes[obstacle.number] = obstacle.shape
            self.shapes = tuple(shapes.values())
        self.version, self.obstacles, self.parts = roster.version, roster.obstacles, roster.parts
        return [
            each
            for each in self.members.values()
            if each.robot != self._robot and before.get(each.robot) != each
        ]

    def member(self, robot: int) -> Member | None:
        """The entry of an id; None if the roster has none."""
        return self.members.get(robot)


def has_ended(roster: Roster, robot: int, incarnation: int) -> bool:
    """Whether a roster ends this incarnation: its disk is static, or the robot has a newer one."""
    for member in roster.members:
        if member.robot == robot and member.incarnation >= incarnation:
            return member.incarnation > incarnation or member.status != "live"
    return False


class FleetRadii(NamedTuple):
    """The robots of a fleet. Immutable.

    Attributes:
        ids: of all robots.
        radii: of their disks, m, by id.
    """

    ids: frozenset[int]
    radii: Mapping[int, float]


@keeps_newest
def fleet_of(robots: tuple[RobotSpec, ...]) -> FleetRadii:
    """The fleet of a scenario's robots."""
    radii = {robot.id: robot.radius for robot in robots}
    return FleetRadii(frozenset(radii), radii)


class Neighbours:
    """The newest States of peers, each of the life in the roster.

    Args:
        radii: of all robots, m, by id; not modified.
        hears_all: whether this robot receives the States of all peers; otherwise a new life may be too far.

    Attributes:
        members: entries of the newest roster, by id; shared, not modified.
        standing: roster entries of disks that are static or appearing, by id.
        picture: the newest summary of all positions; None before the first, and if all peers are received.
        far: terms in the slice of the peers whose States are not received.
        radii: newest known, m, by id.
    """

    def __init__(self, radii: Mapping[int, float], *, hears_all: bool = True) -> None:
        self.standing: dict[int, Member] = {}
        self.picture: FarPicture | None = None
        self.far = NOTHING
        self.radii = radii
        self._hears_all = hears_all
        self.members: Mapping[int, Member] = {}
        self._states: dict[int, PeerState | None] = {}

    def state(self, peer: int) -> PeerState | None:
        """The newest State of a peer."""
        return self._states.get(peer)

    def on_state(self, state: PeerState, tick: int) -> bool:
        """Accept a peer's State if it is newer, and of the present life; returns whether it is."""
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
        """Apply a changed entry of a newer roster, whose entries are in `members`. The disk of a peer that
        restarts is static until its first State."""
        robot = member.robot
        if self.radii.get(robot) != member.radius:
            self.radii = {**self.radii, robot: member.radius}  # the others share the one given
        if member.status in ("standing", "appearing"):
            self.standing[robot] = member
            if robot not in self._states:
                self._keep(robot, None)
        elif member.status == "live" and not self._hears_all:
            self.standing.pop(robot, None)
        elif member.status == "gone":
            self.standing.pop(robot, None)
            self._states.pop(robot, None)

    def _keep(self, robot: int, state: PeerState | None) -> None:
        """Keep peers in the order of their ids, on which sums depend in the last bit."""
        if robot in self._states:
            self._states[robot] = state
        else:
            self._states = dict(sorted({**self._states, robot: state}.items()))

    def attend(self, heard: Iterable[int]) -> None:
        """Keep the States of these peers and of static disks, and drop the others."""
        kept = sorted({*heard, *self.standing})
        if kept != list(self._states):
            self._states = {peer: self._states.get(peer) for peer in kept}

    @property
    def known(self) -> Iterable[int]:
        """Peers whose States are kept, received or not."""
        return self._states.keys()

    def heard(self) -> list[PeerState]:
        """The newest State of each peer from which one was received."""
        return [state for state in self._states.values() if state is not None]

    def moving(self) -> list[PeerState]:
        """The newest States of peers that are not static."""
        if not self.standing:
            return self.heard()
        return [state for state in self.heard() if state.robot not in self.standing]

    def disks(self) -> list[Peer]:
        """Peers with a known position. A static one has gamma 0, like an obstacle, since it never arrives."""
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
        """The newest known position of a peer, m; None if there is none."""
        stood, state = self._stands_at(peer), self.state(peer)
        if stood is not None:
            return stood
        return None if state is None else state.position

    def _stands_at(self, peer: int) -> tuple[float, float] | None:
        member = self.standing.get(peer)
        return None if member is None else member.position
