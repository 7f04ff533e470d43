"""A robot's peers by roster and States, and the tick in which each State takes effect.

Sender and tick of a State decide whether it is accepted; its arrival time does not. Proposals and answers
take effect only between a Tick and the own Command, when no command is in force; later ones wait for the
next Tick.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Final

from agents.peers.far import NOTHING, Arrivals, FarPicture, SummaryPlaces
from agents.peers.link import StateLink
from agents.peers.state import Peer, PeerState
from protocol.codec import keeps_newest
from protocol.geometry import Shape
from protocol.messages import Member, PartPlace, PlacedObstacle, Roster, Tick, Vector
from protocol.scenario.model import RobotSpec, Scenario

_NEVER: Final = 2**62


@keeps_newest
def radii_of(robots: tuple[RobotSpec, ...]) -> dict[int, float]:
    """Radii of the robots of a fleet, m, by id. Immutable: robots of one process share them."""
    return {robot.id: robot.radius for robot in robots}


@keeps_newest
def _by_id(members: tuple[Member, ...]) -> tuple[dict[int, Member], dict[int, int]]:
    """Members, and incarnations of live ones, by id. Immutable: robots of one process share them."""
    lives = {each.robot: each.incarnation if each.status == "live" else -1 for each in members}
    return {each.robot: each for each in members}, lives


class Neighbours:
    """All disks, obstacles and parts of the newest roster, and the newest States of peers, of the lives that
    the roster names.

    Args:
        radii: of all robots, m, by id; not modified.
        listed: shapes of the scenario's obstacles, by number; not modified.
        hears_all: whether this robot receives the States of all peers, not of near ones only.
    """

    def __init__(
        self,
        radii: dict[int, float],
        *,
        robot: int = 0,
        listed: Mapping[int, Shape] | None = None,
        hears_all: bool = True,
    ) -> None:
        self.version = 0  # of the roster; 0 before the first
        self.members: dict[int, Member] = {}  # its entries, by id, in its order
        self.obstacles: tuple[PlacedObstacle, ...] = ()  # its added and removed ones
        self.parts: tuple[PartPlace, ...] = ()  # the place of each part
        self._listed = {} if listed is None else listed
        self.numbered = self._listed  # shapes of all obstacles that are present or appearing, by number
        self.shapes = tuple(self._listed.values())  # the same shapes
        self.standing: dict[int, Member] = {}  # entries of disks that are static or appearing, by id
        self.picture: FarPicture | None = None  # the newest summary of all positions, if there is any
        self.far = NOTHING  # terms in the slice of the peers whose States are not received
        self.radii = radii  # newest known, m, by id
        self._robot, self._hears_all = robot, hears_all
        # Incarnation of each live robot, by id; -1 if the disk is not live.
        self.lives: dict[int, int] = {}  # not Mapping, nor are `radii`: compiled, looked up thrice as fast
        self._states: dict[int, PeerState | None] = {}

    def state(self, peer: int) -> PeerState | None:
        """The newest State of a peer."""
        return self._states.get(peer)

    def on_state(self, state: PeerState, tick: int) -> bool:
        """Accept a peer's State if it is newer, and of the present life; returns whether it is."""
        life = self.lives.get(state.robot)
        if life is not None and life != state.incarnation:
            return False
        before = self._states.get(state.robot)
        if not state.follow(before, tick):
            return False
        if before is None:
            self._keep(state.robot, state)
        else:
            self._states[state.robot] = state
        self.standing.pop(state.robot, None)
        return True

    def on_roster(self, roster: Roster) -> None:
        """Adopt a roster if it is newer."""
        if roster.version <= self.version:
            return
        before = self.members
        self.members, self.lives = _by_id(roster.members)
        if roster.obstacles != self.obstacles:
            shapes = dict(self._listed)
            for obstacle in roster.obstacles:
                shapes.pop(obstacle.number, None)
                if obstacle.status != "gone":
                    shapes[obstacle.number] = obstacle.shape
            self.numbered, self.shapes = shapes, tuple(shapes.values())
        self.version, self.obstacles, self.parts = roster.version, roster.obstacles, roster.parts
        for robot, member in self.members.items():
            if robot != self._robot and before.get(robot) != member:
                self._on_member(member)

    def _on_member(self, member: Member) -> None:
        """Apply a changed entry. A peer that restarts is static until its first State."""
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
        self._states = dict(sorted({**self._states, robot: state}.items()))

    def attend(self, heard: Iterable[int]) -> None:
        """Keep the States of these peers and of static disks, and drop the others."""
        self._states = {peer: self._states.get(peer) for peer in sorted({*heard, *self.standing})}

    @property
    def known(self) -> Iterable[int]:
        """Peers whose States are kept, received or not."""
        return self._states.keys()

    def heard(self) -> list[PeerState]:
        """The newest State of each peer from which one was received."""
        return [state for state in self._states.values() if state is not None]

    def moving(self) -> list[PeerState]:
        """The newest States of peers that are not static."""
        return [state for state in self.heard() if state.robot not in self.standing]

    def disks(self) -> list[Peer]:
        """Peers with a known position; a static one has gamma 0, as an obstacle has."""
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


class PeerInbox:
    """The inbox of one life of one robot.

    Args:
        accepted: takes each accepted State, with its proposals and answers.
        lockstep: whether the world waits for this robot. If not, States of missed ticks are accepted.
    """

    def __init__(
        self, scenario: Scenario, robot: int, accepted: Callable[[PeerState], None], *, lockstep: bool
    ) -> None:
        self.neighbours = Neighbours(
            radii_of(scenario.robots),
            robot=robot,
            listed=scenario.shapes,
            hears_all=not scenario.hears_near,
        )
        self._accepted = accepted
        self._robot, self._tick, self._lockstep = robot, -1, lockstep
        self._link = StateLink(scenario, robot)
        self._far = Arrivals(scenario, robot) if scenario.hears_near else None
        self._since: dict[int, int] = {}  # tick of the first State that may be accepted, by peer
        self._active: tuple[int, ...] = ()  # as the tick before named them
        self._awaited: set[int] = set()
        self.is_open = False  # whether the tick's State is out and its Command is not

    def open(self, tick: Tick, place: Vector | None = None) -> None:
        """Begin a tick at `place`, m: await the States of the peers that it names, and accept late ones."""
        self._link.locate(tick.tick, place)
        self._attend(tick)
        self._tick = tick.tick
        self._awaited = set(self._since).difference(self._link.ahead(tick.tick))
        if self._far is not None:
            self._far.open(tick.tick)
        self._take(tick.tick - 1)
        self.is_open = True

    def _attend(self, tick: Tick) -> None:
        """In lock-step, States of ticks that this robot missed are dropped: their arrival depends on the wall
        clock, as no tick awaited it, and accepting them would make runs differ."""
        before, now = self._since, tick.tick
        if self._lockstep and now > self._tick + 1:
            before = {}
        elif tick.active == self._active:
            return
        self._active = tick.active
        self._since = {peer: before.get(peer, now) for peer in tick.active if peer != self._robot}

    def close(self) -> None:
        """The tick's Command is due: accept the States that arrived in time."""
        self.is_open = False
        self._take(self._tick)

    def reconsider(self, tick: Tick) -> None:
        """The same tick again, with fewer active robots: await no State of those that left it."""
        self._awaited.intersection_update(tick.active)

    def on_state(self, state: PeerState) -> None:
        """Receive a peer's State, perhaps repeated."""
        tick = state.tick
        if tick >= self._tick:  # of any incarnation: a wrong one must not block the tick
            self._awaited.discard(state.robot)
        if self.is_open and tick <= self._tick and self._link.ideal:
            self._learn(state)  # as `close` would in a moment
        else:
            self._link.put(state)

    def on_summary(self, places: SummaryPlaces) -> None:
        """Receive the world's summary of all positions."""
        if self._far is not None:
            self._far.on_summary(places)

    def look_afar(self, position: Vector, radius: float) -> None:
        """Apply the summary that is due, once: the far field around the own disk (m)."""
        picture = None if self._far is None else self._far.new_picture(self.neighbours.radii)
        if picture is None:
            return
        known = {self._robot, *self.neighbours.known, *self.neighbours.standing}
        self.neighbours.picture = picture
        self.neighbours.far = picture.field(position, radius, known)

    @property
    def complete(self) -> bool:
        """Whether all States awaited in this tick have arrived, and the summary that is due; real time awaits
        none."""
        if not self._lockstep:
            return True
        return not self._awaited and (self._far is None or self._far.has_summary)

    @property
    def missing(self) -> list[int]:
        """Robots whose States have not arrived."""
        return sorted(self._awaited)

    def _take(self, tick: int) -> None:
        for state in self._link.take(tick):
            self._learn(state)

    def _learn(self, state: PeerState) -> None:
        if state.tick < self._since.get(state.robot, _NEVER):
            return
        state.size(self.neighbours.radii.get(state.robot, 0.0))
        if self.neighbours.on_state(state, self._tick):
            # Repeated, it is no news, even if this peer was dropped meanwhile.
            self._since[state.robot] = state.tick + 1
            self._accepted(state)
