"""The core of a robot: messages and ticks go in, messages come out; no socket, no clock, no global state.

A tick has two phases. `measure` takes the Measurement and gives the State; `command`, once the peers'
States are heard (or right away, in real time), gives the Command. Line messages are taken over only from
the one to the other, when every earlier command is settled: none is ever outstanding (`agents.lines`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from agents.estimate import Estimate
from agents.laws import choose
from agents.lines.boundary import RoundBoundary
from agents.lines.ledger import Ledger
from agents.link import Link
from agents.neighbours import Neighbours
from agents.peer_state import PeerState
from agents.safe_velocity import safe_velocity
from protocol.messages import Answer, Command, Health, Measurement, Proposal, State
from protocol.scenario import Scenario

Vector = tuple[float, float]
STILL: Vector = (0.0, 0.0)
CORNERS: Final = 4  # that the workspace cuts off the own set in a tick, at most


class Robot:
    """One life of one robot.

    Args:
        scenario: the run; k already a number.
        robot: own id.
        incarnation: this life, as handed out by the world.
        first_lives: everybody's first incarnation in this run, which begins at the start.
    """

    def __init__(
        self, scenario: Scenario, robot: int, incarnation: int, first_lives: Mapping[int, int]
    ) -> None:
        spec = scenario.spec(robot)
        self.tick = -1
        self.robot, self.incarnation = robot, incarnation
        self._scenario, self._control = scenario, scenario.control
        self._goal, self._radius = spec.goal, spec.radius
        self._filtered = scenario.control.filter == "separating-lines"
        self._law = choose(scenario, robot)
        speed, period = scenario.control.speed * (1.0 + scenario.actuation.bound), scenario.time.step
        sensing = scenario.sensing_of(robot)
        self._estimate = Estimate(sensing.bound, speed * period, sensing.contradiction == "newest")
        self._boundary = RoundBoundary(scenario.workspace.radius - spec.radius)
        radii = {peer.id: peer.radius for peer in scenario.robots}
        self._neighbours = Neighbours({peer: radii[peer] for peer in radii if peer != robot})
        self._link = Link(scenario, robot)
        first = incarnation == first_lives.get(robot)
        self._lines = Ledger(
            robot,
            incarnation,
            radii,
            speed=speed,
            period=period,
            starts={peer.id: peer.start for peer in scenario.robots} if first else None,
            first_lives=first_lives,
        )
        self._awaited: set[int] = set()
        self._ahead: dict[int, int] = {}  # newest tick, by peer that is ahead of this robot
        self._desired = self._moved = STILL
        self._open = False  # whether the tick's State is out and its Command is not

    # -- phase 1

    def measure(self, measurement: Measurement) -> State:
        """Open a tick; returns the State to publish."""
        self.tick = measurement.tick
        self._await(measurement.active)
        self._estimate.update(measurement)
        self._moved = measurement.displacement
        self._locate()
        for down in self._neighbours.fence(measurement.down):
            self._lines.peer_down(down)
        self._take_over(self.tick - 1)
        self._open = True
        return self._state()

    def _locate(self) -> None:
        """Tell the lines where this robot is; what they and the workspace exclude, it is not."""
        estimate = self._estimate
        if estimate.position is None:
            return
        if estimate.shape is None or not self._filtered:
            self._lines.locate(self.tick, estimate.position, estimate.bound)
            return
        for _ in range(CORNERS):
            edge = self._boundary.beyond(*estimate.position, estimate.shape)
            if edge is None or not estimate.confine(edge, "the workspace"):
                break
        self._lines.locate(self.tick, estimate.position, estimate.bound, estimate.shape)
        crossed = self._lines.crossed()
        for peer, side in crossed:
            estimate.confine(side, f"the line with robot {peer}")
        if crossed or estimate.lost:
            bound = math.inf if estimate.lost else estimate.bound  # lost: nothing is surely satisfied
            self._lines.locate(self.tick, estimate.position, bound, estimate.shape)

    def _await(self, active: Iterable[int]) -> None:
        """Await this tick's State of all that take part and have not sent it yet."""
        self._awaited = set(active)
        self._awaited.discard(self.robot)
        if self._ahead:
            self._ahead = {peer: tick for peer, tick in self._ahead.items() if tick >= self.tick}
            self._awaited.difference_update(self._ahead)

    def _state(self) -> State:
        position = self._estimate.position
        proposals: tuple[Proposal, ...] = ()
        answers: tuple[Answer, ...] = ()
        gamma = slice_norm = 0.0
        if position is not None:
            gamma = (position[0] - self._goal[0]) ** 2 + (position[1] - self._goal[1]) ** 2
            slice_norm = self._law.slice_norm(position)
            if self._filtered:
                proposals, answers = self._lines.speak(self._desired)
        return State(
            self.robot,
            self.incarnation,
            self.tick,
            position,
            self._estimate.bound if position is not None else 0.0,
            gamma,
            slice_norm,
            self._desired,
            proposals,
            answers,
        )

    def reconsider(self, measurement: Measurement) -> None:
        """The same tick again: somebody who took part no longer does, and is not waited for."""
        self._awaited.intersection_update(measurement.active)

    # -- between the phases

    def hear(self, state: PeerState) -> None:
        """The State of a peer of this run has arrived."""
        robot, tick = state.robot, state.tick
        if self._open and tick <= self.tick and self._link.ideal:
            self._learn(state)  # as `command` would in a moment
        else:
            self._link.put(state)
        if tick >= self.tick:
            self._awaited.discard(robot)
        if tick > self.tick and tick > self._ahead.get(robot, -1):
            self._ahead[robot] = tick

    @property
    def complete(self) -> bool:
        """Whether the States of all that take part in this tick have arrived."""
        return not self._awaited

    # -- phase 2

    def command(self) -> Command:
        """Close the tick; returns the Command to publish."""
        self._open = False
        self._take_over(self.tick)
        position = self._estimate.position
        velocity = STILL
        if position is None:
            self._desired = STILL
        else:
            self._desired = self._law.velocity(position, self._moved, self._neighbours, self.tick)
            velocity = self._allowed(position, self._lines.make_room(self._desired))
        return Command(self.robot, self.incarnation, self.tick, velocity)

    def _take_over(self, tick: int) -> None:
        """Hear all States that are due by `tick`."""
        for state in self._link.take(tick):
            self._learn(state)

    def _learn(self, state: PeerState) -> None:
        self._neighbours.hear(state)
        self._lines.hear(state)

    def _allowed(self, position: Vector, desired: Vector) -> Vector:
        """The velocity nearest to the desired one that keeps to all lines, the workspace and the limit."""
        if not self._filtered:
            return desired
        if not self._lines.ready or self._estimate.lost:
            return STILL
        return safe_velocity(
            desired,
            position,
            self._lines.half_planes(),
            boundary=self._boundary,
            speed=self._control.speed,
            period=self._scenario.time.step,
            shape=self._estimate.shape,
            noise=self._scenario.actuation.bound,
        )

    # -- about itself

    def is_down(self, measurement: Measurement) -> bool:
        """Whether the world has fenced this life."""
        return any(d.robot == self.robot and d.incarnation >= self.incarnation for d in measurement.down)

    @property
    def note(self) -> str:
        """What a person should know of this robot; "" if nothing."""
        if not self._estimate.contradiction:
            return ""
        does = "stands still" if self._estimate.lost else "begins anew from the newest measurement"
        return f"{self._estimate.contradiction}; {does}"

    def health(self, published: int, received: int, rejected: dict[str, int]) -> Health:
        """What a monitor may want to know."""
        heard = tuple(sorted((state.robot, state.tick) for state in self._neighbours.heard()))
        position, bound = self._estimate.position, self._estimate.bound
        lines = self._lines.sides() if self._filtered else ()
        return Health(
            self.robot,
            self.incarnation,
            max(self.tick, 0),
            bound if position is not None else 0.0,
            published,
            received,
            rejected,
            heard,
            lines,
            self.note,
        )
