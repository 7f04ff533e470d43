"""The core of a robot: messages and ticks go in, messages come out; no socket, no clock, no global state.

A tick has two phases. `begin` takes the Tick and returns the State; `command`, once the peers' States have
arrived (or at once, in real time), returns the Command.
"""

from __future__ import annotations

from math import hypot
from typing import Final

from agents.bodies import body_of
from agents.estimate import Estimate
from agents.law import GuardedLaw, View
from agents.law.pace import may_move
from agents.parts.carrier import PartCarrier
from agents.peers.neighbours import PeerInbox
from agents.peers.state import plausible
from agents.safety_filter import SafetyFilter
from protocol.crowd import period
from protocol.kernel.records import NO
from protocol.messages import (
    STILL,
    Answer,
    Command,
    Handling,
    Health,
    Line,
    Proposal,
    Report,
    Roster,
    Sense,
    State,
    Tick,
    Vector,
)
from protocol.scenario.body import span_of
from protocol.scenario.model import Scenario

NAMED: Final = 100  # most robots in a complaint: the size of a Command is limited


class Robot:
    """One life of one robot. It stands still until the ledger has granted it a region.

    Args:
        scenario: k already a number.
        lockstep: whether the world waits for it.
        epoch: of the coordinator that admitted it.
    """

    def __init__(
        self, scenario: Scenario, robot: int, incarnation: int, *, lockstep: bool = True, epoch: int = 0
    ) -> None:
        spec = scenario.spec(robot)
        self.tick = -1
        self.robot, self.incarnation, self.epoch = robot, incarnation, epoch
        self.goal = self._first_goal = spec.goal  # m; stored only here, since every Tick may change it
        self._ordered: Vector | None = None  # goal of the newest order
        self.scenario, self._spec = scenario, spec
        self._body, self._plausible = body_of(scenario, robot), plausible(scenario)
        self._estimate = self._nothing_known()
        self._filter = SafetyFilter(scenario, robot, spec.radius, self._body)
        self.inbox = PeerInbox(scenario, robot, self._filter.lines.on_state, lockstep=lockstep)
        self._peers = self.inbox.neighbours
        self._law = GuardedLaw(scenario, robot)
        self._mover = PartCarrier(scenario, robot) if scenario.parts else None
        self._period = period(scenario) if scenario.hears_near else 0  # ticks, of summaries
        self._desired = self._moved = STILL
        self._blind = True  # whether the displacement of the last tick is unknown
        self._halted = False  # an emergency stop is in force
        self.stopped = False  # it has to stand, apart from an emergency stop of all

    # -- phase 1: sense, follow the roster, accept late States, publish the State

    def begin(self, tick: Tick, sense: Sense | None = None) -> State:
        """Open a tick; returns the State to publish. `sense` is from the own base, unless the Tick brings
        it."""
        self.tick = tick.tick
        self._ordered = self._ordered if tick.goal is None else tick.goal
        self.goal = self._first_goal if self._ordered is None else self._ordered
        self._halted = tick.halted
        self._sense(tick.sense if sense is None else sense)
        if tick.roster is not None:
            self._follow(tick.roster)
        if tick.grants is not None:
            self._filter.lines.on_grants(tick.grants, self._peers)
            self._peers.attend(self._filter.lines.peers)
        self._filter.locate(self.tick, self._estimate, blind=self._blind)
        self.inbox.open(tick, self._estimate.position)
        if self._mover is not None:
            self._move_parts(self._mover)
        return self._state()

    def reset_estimate(self) -> None:
        """Reset the position estimate: only measurements from now on are used."""
        self._estimate = self._nothing_known()

    def _nothing_known(self) -> Estimate:
        scenario, sensing = self.scenario, self.scenario.sensing_of(self.robot)
        return Estimate(
            self._body.reach,
            sensing.contradiction == "newest",
            scenario.ticks(span_of(sensing.delay)[1]),
            coasts=not scenario.body_of(self.robot).ideal,
        )

    def _sense(self, sense: Sense | None) -> None:
        """Update the position estimate; the displacement of a tick without odometry is unknown."""
        self._blind = sense is None
        if sense is not None:
            self._estimate.update(self.tick, sense)
            self._body.on_motion(sense.motion)
        self._moved = STILL if sense is None else sense.displacement

    def _follow(self, roster: Roster) -> None:
        first = self._peers.version == 0
        self._peers.on_roster(roster)
        own = self._peers.members.get(self.robot)
        if first and own is not None:
            self._filter.resize(own.radius)  # an earlier life may carry a part

    def _state(self) -> State:
        position, bound = self.place
        proposals: tuple[Proposal, ...] = ()
        answers: tuple[Answer, ...] = ()
        gamma = slice_norm = 0.0
        if position is not None:
            gamma = (position[0] - self.goal[0]) ** 2 + (position[1] - self.goal[1]) ** 2
            slice_norm = self._law.slice_norm(position, self.goal)
            if self._filter.obeyed:
                proposals, answers = self._filter.lines.entries(self._desired)
        claim = None if self._mover is None else self._mover.claim
        return State(
            *self._life,
            position=position,
            bound=bound or 0,  # an integer takes one byte of nine
            gamma=gamma,
            slice=slice_norm,
            desired=self._desired,
            epoch=self.epoch,
            proposals=proposals,
            answers=answers,
            claim=claim,
        )

    @property
    def _life(self) -> tuple[int, int, int]:
        return self.robot, self.incarnation, self.tick

    @property
    def place(self) -> tuple[Vector | None, float]:
        """Position estimate and its error bound, m; no position if the estimate is implausible."""
        position, bound = self._estimate.position, self._estimate.bound
        if position is None or not self._plausible.locates(position, bound):
            return None, 0.0
        return position, bound

    def on_wish(self, wish: Vector) -> None:
        """Pass on a wish, m/s, for the law "external"."""
        self._law.on_wish(wish, self.tick)

    # -- phase 2: accept States, apply the law, filter, command

    def command(self) -> Command:
        """Close the tick; returns the Command to publish."""
        self.inbox.close()
        self._desired, velocity = STILL, STILL
        handles: Handling | None = None
        filter_, position = self._filter, self._estimate.position
        if position is not None:
            self.inbox.look_afar(position, filter_.radius)
        if self._mover is not None:
            handles = self._fit_to_load(self._mover, filter_)
        if position is not None and not (self._halted or self.stopped):
            self._desired = self._wish(position)
            velocity = filter_.velocity(self._desired, self._estimate)
        lines = filter_.lines
        return Command(
            *self._life,
            velocity=velocity,
            epoch=self.epoch,
            roster=self._peers.version,
            report=self._report() if self.scenario.is_external else None,
            version=lines.version,
            region=lines.region,
            firsts=lines.firsts(),
            handles=handles,
            slice=self._summed_up(),
        )

    def complaint(self) -> Command:
        """A Command without a velocity; it lists the robots with missing States."""
        missing = tuple(self.inbox.missing[:NAMED])
        return Command(*self._life, STILL, epoch=self.epoch, roster=self._peers.version, awaits=missing)

    def _wish(self, position: Vector) -> Vector:
        """The velocity that the law desires; of a carrier with a waypoint, straight to that."""
        if not may_move(self.scenario, self.robot, self.tick):
            return STILL
        aim = None if self._mover is None else self._mover.aim
        if aim is None:
            peers = self._peers
            return self._law.velocity(View(self.tick, position, self.goal, self._moved, peers, peers.shapes))
        dx, dy = aim[0] - position[0], aim[1] - position[1]
        rate = min(self.scenario.control.speed / max(hypot(dx, dy), 1e-12), 1.0 / self.scenario.time.step)
        return rate * dx, rate * dy

    def _report(self) -> Report | None:
        """The position as the tick began; None in a tick without odometry."""
        position, bound = self.place
        if position is None or self._blind or self._estimate.lost:
            return None
        return Report(position, bound)

    # -- for the summary

    def _summed_up(self) -> float | None:
        """The norm of the own slice for the summary of the next tick, if there is one."""
        position = self._estimate.position
        if position is None or not self._period or (self.tick + 1) % self._period:
            return None
        return self._law.slice_norm(position, self.goal)

    # -- parts

    def _move_parts(self, mover: PartCarrier) -> None:
        """Decide on parts in this tick; a robot with an order leaves them alone."""
        position = self._estimate.position
        if position is not None:
            mover.look(self.tick, position, self._peers, self._ordered)
            self.goal = mover.goal

    def _fit_to_load(self, mover: PartCarrier, filter_: SafetyFilter) -> Handling | None:
        """Adopt the disk that parts require, if there is room for a larger one; returns the request if so.

        It is never smaller than the roster's, which is the obstacle if this robot fails.
        """
        own = self._peers.members.get(self.robot)
        before = filter_.radius
        listed = before if own is None else own.radius
        part, radius = -mover.held, mover.radius
        has = radius <= listed or (radius <= before and filter_.lines.part in (NO, part))
        if not has and not filter_.enlarge(radius, part, self._estimate):
            radius = self._spec.radius
        radius = max(listed, radius)
        if radius != filter_.radius:
            filter_.resize(radius)
        filter_.lines.wanted = mover.radius
        if radius != before and not self._law.failure:
            self._law = GuardedLaw(self.scenario.resized({self.robot: radius}), self.robot)
        return mover.handles if filter_.radius >= mover.radius else None

    # -- about itself

    def has_ended(self, tick: Tick) -> bool:
        """Whether the Tick's roster ends this life: its disk is static, or the robot has a newer one."""
        for member in () if tick.roster is None else tick.roster.members:
            if member.robot == self.robot and member.incarnation >= self.incarnation:
                return member.incarnation > self.incarnation or member.status != "live"
        return False

    @property
    def radius(self) -> float:
        """Of the own disk, m."""
        return self._filter.radius

    @property
    def lines(self) -> tuple[Line, ...]:
        """Separating lines that this robot obeys."""
        return self._filter.lines.obeyed_lines() if self._filter.obeyed else ()

    @property
    def lost(self) -> bool:
        """Whether the robot stands because its measurements contradict the stated bounds."""
        return self._estimate.lost

    @property
    def note(self) -> str:
        """Warnings about this robot, for the operator; "" if none."""
        return "; ".join(self.troubles)

    @property
    def troubles(self) -> list[str]:
        """The warnings one by one: a failed law, contradicting measurements."""
        found = [f"{self._law.failure}; it stands from here on"] if self._law.failure else []
        if self._estimate.contradiction:
            does = "stands still" if self._estimate.lost else "starts over from the newest measurement"
            found.append(f"{self._estimate.contradiction}; {does}")
        return found

    def health(self, published: int, received: int, rejected: dict[str, int]) -> Health:
        """The report for monitors."""
        heard = tuple(sorted((state.robot, state.tick) for state in self._peers.heard()))
        _, bound = self.place
        life = self.robot, self.incarnation, max(self.tick, 0)
        return Health(*life, bound, published, received, rejected, heard, self.lines, self.note)
