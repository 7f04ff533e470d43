"""Receives peers' States and the world's summaries, decides when each takes effect, and lists missing States.

Sender and tick of a State decide whether it is accepted; its arrival time does not. Proposals and answers
take effect only between a Tick and the own Command, when no command is in force; later ones wait for the next
Tick.
"""

from __future__ import annotations

from typing import Final

from agents.lines.separating_lines import SeparatingLines
from agents.peers.far import Arrivals, places_of
from agents.peers.link import StateLink
from agents.peers.neighbours import Neighbours, fleet_of
from agents.peers.state import PeerState
from protocol.messages import Summary, Tick, Vector
from protocol.scenario.model import Scenario

_NEVER: Final = 2**62


class PeerInbox:
    """The inbox of one life of one robot.

    Args:
        scenario: the run.
        robot: own id.
        lines: receive the proposals and answers of accepted States.
        lockstep: whether the world waits for this robot. If not, States of missed ticks are accepted.

    Attributes:
        neighbours: peers, by their newest States and the roster.
    """

    def __init__(self, scenario: Scenario, robot: int, lines: SeparatingLines, *, lockstep: bool) -> None:
        self.neighbours = Neighbours(fleet_of(scenario.robots).radii, hears_all=not scenario.hears_near)
        self._lines = lines
        self._robot, self._tick, self._lockstep = robot, -1, lockstep
        self._link = StateLink(scenario, robot)
        self._far = Arrivals(scenario, robot) if scenario.hears_near else None
        self._since: dict[int, int] = {}  # tick of the first accepted State, by peer
        self._active: tuple[int, ...] = ()  # of the tick before
        self._awaited: set[int] = set()
        self._open = False  # between the tick's State and its Command

    def open(self, tick: Tick, place: Vector | None = None) -> None:
        """Begin a tick: await the States of its active peers, and accept late States that are due.

        Args:
            tick: from the coordinator.
            place: position of this robot, m, if known.
        """
        self._link.locate(tick.tick, place)
        self._attend(tick)
        self._tick = tick.tick
        self._awaited = set(self._since).difference(self._link.ahead(tick.tick))
        if self._far is not None:
            self._far.open(tick.tick)
        self._take(tick.tick - 1)
        self._open = True

    def _attend(self, tick: Tick) -> None:
        """In lock-step, States of ticks that this robot missed are dropped: no tick awaited their delivery,
        so their arrival depends on the wall clock, and accepting them would make runs differ."""
        before, now = self._since, tick.tick
        if self._lockstep and now > self._tick + 1:
            before = {}
        elif tick.active == self._active:
            return
        self._active = tick.active
        self._since = {peer: before.get(peer, now) for peer in tick.active if peer != self._robot}

    def close(self) -> None:
        """The tick's Command is due: accept the States that arrived in time."""
        self._open = False
        self._take(self._tick)

    def reconsider(self, tick: Tick) -> None:
        """The same tick with fewer active robots: do not await the States of those that left it."""
        self._awaited.intersection_update(tick.active)

    def on_state(self, state: PeerState) -> None:
        """Receive the State of a peer of this run, perhaps repeated."""
        tick = state.tick
        if tick >= self._tick:  # of any incarnation, so that a wrong one cannot block the tick
            self._awaited.discard(state.robot)
        if self._open and tick <= self._tick and self._link.ideal:
            self._learn(state)  # as `close` would in a moment
        else:
            self._link.put(state)

    def on_summary(self, summary: Summary) -> None:
        """Receive the world's summary of positions for a later tick; raises MessageError."""
        if self._far is not None:
            self._far.on_summary(places_of(summary))

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
        """Whether all States awaited in this tick have arrived, and the summary that is due."""
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
            self._lines.on_state(state)
