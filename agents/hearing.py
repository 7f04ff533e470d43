"""What a robot hears of its peers: from whom, when it is due, and what is still missing.

Line messages are taken over only while no command is outstanding: what is heard when a tick is not open
waits for the next.
"""

from __future__ import annotations

from agents.lines.separating_lines import SeparatingLines
from agents.peers.attention import Attention
from agents.peers.awaited import Awaited
from agents.peers.far import places_of
from agents.peers.fleet import fleet_of
from agents.peers.link import Link
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState, from_afar
from protocol.crowd.interest import period, turn
from protocol.messages import Summary, Tick, Vector
from protocol.scenario.model import Scenario


class Hearing:
    """The ear of one incarnation of one robot.

    Args:
        scenario: the run.
        robot: own id.
        lockstep: whether the world waits for it.

    Attributes:
        neighbours: what is known of peers.
        lines: are told what peers say of them; until there are any, all that is said has to wait.
    """

    def __init__(self, scenario: Scenario, robot: int, *, lockstep: bool) -> None:
        self.neighbours = Neighbours(fleet_of(scenario.robots).radii, everybody=not scenario.hears_near)
        self.lines: SeparatingLines | None = None
        self._robot, self._tick = robot, -1
        self._period = period(scenario) if scenario.hears_near else 0  # ticks, of summaries
        self._link, self._awaited = Link(scenario, robot), Awaited(robot)
        self._attention = Attention(turn(scenario, robot), lockstep=lockstep)
        self._open = False  # whether the tick's State is out and its Command is not

    def open(self, tick: Tick) -> None:
        """A tick begins: hear whom it says, and what was late."""
        self._tick = tick.tick
        self._attend(tick)
        self._awaited.begin(tick.tick, self._attention.near if tick.active is None else tick.active)
        for letter in tick.letters:  # by way of the world; the link's faults are between robots all the same
            radius = self.neighbours.radii.get(letter.robot)
            if radius is not None:
                self._link.put(from_afar(self._robot, letter, radius))
        self._take(tick.tick - 1)
        self._open = True

    def close(self) -> None:
        """The tick's Command is due: take over what has come in time."""
        self._open = False
        self._take(self._tick)

    def reconsider(self, tick: Tick) -> None:
        """The same tick again: somebody who took part no longer does, and is not waited for."""
        if tick.active is not None:
            self._awaited.reduce(tick.active)

    def on_state(self, state: PeerState) -> None:
        """The State of a peer of this run has arrived, perhaps again."""
        tick, lines = state.tick, self.lines
        self._awaited.arrived(state.robot, tick)  # news or not: a false incarnation must hold up nobody
        if not self._link.is_news(state):
            return
        if self._open and tick <= self._tick and self._link.ideal and lines is not None:
            self._learn(lines, state)  # as `close` would in a moment
        else:
            self._link.put(state)

    def on_summary(self, summary: Summary) -> None:
        """The world says where everybody is, for a tick that begins soon.

        Raises:
            MessageError: it is not made as a summary is.
        """
        self._attention.on_summary(places_of(summary))

    def look_afar(self, position: Vector, radius: float) -> None:
        """Take in the newest summary that is due, if it is news to the own disk (m)."""
        picture = self._attention.new_picture(self.neighbours.radii)
        if picture is None or self.lines is None:
            return
        self.lines.survey(picture)
        known = {self._robot, *self._attention.near, *self.neighbours.standing}
        self.neighbours.picture = picture
        self.neighbours.far = picture.field(position, radius, known)

    @property
    def complete(self) -> bool:
        """Whether the States of all whom this robot hears in this tick have arrived, and the summary due."""
        return not self._awaited.robots and self._attention.has_summary

    @property
    def missing(self) -> list[int]:
        """Whose States have not arrived."""
        return sorted(self._awaited.robots)

    @property
    def everybody(self) -> bool:
        """Whether nobody has said who is near."""
        return self._attention.everybody

    def _attend(self, tick: Tick) -> None:
        """Hear those who are near, as the world says ahead of time; where all hear all it has no say."""
        turned = self._attention.turn(tick.tick)  # first, as the world does: what was announced may be due
        if tick.near is not None and self._period:
            self._attention.announce(tick.tick, tick.near, summed_up=tick.tick % self._period == 0)
        if turned:
            self.neighbours.attend(self._attention.near)
            if self.lines is not None:
                self.lines.attend(self._attention.near)

    def _take(self, tick: int) -> None:
        """Take over all States that are due by `tick`."""
        if self.lines is not None:
            for state in self._link.take(tick):
                self._learn(self.lines, state)

    def _learn(self, lines: SeparatingLines, state: PeerState) -> None:
        if state.is_letter:
            lines.on_letter(state)
        elif self._attention.counts(state.robot, state.tick):
            state.size(self.neighbours.radii[state.robot])
            self.neighbours.on_state(state)
            lines.on_state(state)
