"""The core of a robot: messages and ticks go in, messages come out; no socket, no clock, no global state.

A tick has two phases. `begin` takes the Tick and gives the State; `command`, once the peers'
States are heard (or right away, in real time), gives the Command. Line messages are taken over only from
the one to the other, when every earlier command is settled: none is ever outstanding (`agents.lines`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import hypot, inf
from typing import Final

from agents.bodies.choice import body_of
from agents.estimate import Estimate
from agents.laws import View, choose
from agents.laws.turns import turn_of
from agents.lines.boundary import boundary_of
from agents.lines.separating_lines import SeparatingLines
from agents.lines.things import Things
from agents.movers.mover import Mover
from agents.peers.attention import Attention
from agents.peers.far import FarPicture
from agents.peers.link import Link
from agents.peers.neighbours import Neighbours
from agents.peers.state import FAR, PeerState, addressed_to
from agents.polygon import Polygon
from agents.roster import KnownRoster, has_ended
from protocol.interest import period, urgent
from protocol.messages import (
    Answer,
    Command,
    Handling,
    Health,
    Proposal,
    Report,
    Roster,
    Sense,
    State,
    Summary,
    Tick,
)
from protocol.scenario.model import Scenario

Vector = tuple[float, float]
STILL: Vector = (0.0, 0.0)
NAMED: Final = 100  # robots that a complaint names at most: a Command has a limit
CORNERS: Final = 4  # that the workspace cuts off the own set in a tick, at most


class Robot:
    """One incarnation of one robot.

    It stands still until the first Tick has told it the roster: only then does it know whether
    it began the run, and so knows the initial lines.

    Args:
        scenario: the run; k already a number.
        robot: own id.
        incarnation: this incarnation, as handed out by the world.

    Attributes:
        goal: where to go, m; nothing else of a robot keeps it, and every Tick may set another.
    """

    def __init__(self, scenario: Scenario, robot: int, incarnation: int) -> None:
        spec = scenario.spec(robot)
        self.tick = -1
        self.robot, self.incarnation = robot, incarnation
        self._scenario, self._control = scenario, scenario.control
        self.goal = self._first_goal = spec.goal
        self._filtered = scenario.control.filter == "separating-lines"
        self._law = choose(scenario, robot)
        self._turn = turn_of(scenario, robot)
        self._speed = scenario.control.speed * (1.0 + scenario.actuation.bound)
        self._body = body_of(scenario, robot)
        sensing = scenario.sensing_of(robot)
        latest = sensing.delay[1] if isinstance(sensing.delay, tuple) else sensing.delay
        trusting = sensing.contradiction == "newest"
        self._oldest, self._trusting = scenario.ticks(latest), trusting
        self._coasts = not scenario.body_of(robot).ideal
        self._reports = scenario.is_external
        self._estimate = self._nothing_known()
        self._boundary = boundary_of(scenario.workspace.shape, spec.radius)
        self._mover = Mover(scenario, robot) if scenario.parts else None
        self._spec, self._radius = spec, spec.radius
        self._radii = {peer.id: peer.radius for peer in scenario.robots}
        self._neighbours = Neighbours({peer: self._radii[peer] for peer in self._radii if peer != robot})
        self._link = Link(scenario, robot)
        self._attention = Attention()
        self._picture: FarPicture | None = None  # newest
        self._painted = -1  # tick of the picture that law and lines go by
        self._roster = KnownRoster(robot, incarnation)
        self._kept = 0  # version of the roster that this incarnation keeps to
        self._lines: SeparatingLines | None = None
        self._things: Things | None = None
        self._awaited: set[int] = set()
        self._ahead: dict[int, int] = {}  # newest tick, by peer that is ahead of this robot
        self._desired = self._moved = STILL
        self._blind = True  # whether nothing is known of how far it went in the last tick
        self._halted = False  # an emergency stop is in force
        self._open = False  # whether the tick's State is out and its Command is not

    def _nothing_known(self) -> Estimate:
        return Estimate(self._body.reach, self._trusting, self._oldest, coasts=self._coasts)

    # -- phase 1

    def begin_anew(self) -> None:
        """All that was known of where this robot is was void: only what it senses from here on counts."""
        self._estimate = self._nothing_known()

    def begin(self, tick: Tick, sense: Sense | None = None) -> State:
        """Open a tick; returns the State to publish.

        Args:
            tick: from the coordinator.
            sense: from the own base and localisation, unless the Tick brings it.
        """
        self.tick = tick.tick
        self._await(tick.active)
        self.goal = self._first_goal if tick.goal is None else tick.goal
        self._halted = tick.halted
        self._on_sense(tick.sense if sense is None else sense)
        if tick.roster is not None:
            self._on_roster(tick.roster)
        if tick.near is not None:
            summed_up = tick.tick % period(self._scenario) == 0
            self._attention.announce(tick.tick, tick.near, summed_up=summed_up)
        if self._attention.turn(tick.tick):
            self._neighbours.attend(self._attention.near)
            if self._lines is not None:
                self._lines.attend(self._attention.near)
        for letter in tick.letters:
            self._on_letter(letter)
        if self._lines is not None:
            self._take_over(self._lines, self.tick - 1)
        if self._mover is not None:
            self._move_parts(self._mover, tick.goal)
        self._open = True
        return self._state()

    def _on_sense(self, sense: Sense | None) -> None:
        """Take in where this robot is; nothing is known of a tick without odometry."""
        self._blind = sense is None
        if sense is not None:
            self._estimate.update(self.tick, sense)
            self._body.on_motion(sense.motion)
        self._moved = STILL if sense is None else sense.displacement
        self._locate()

    def _locate(self) -> None:
        """Tell the lines where this robot is."""
        estimate, lines, things = self._estimate, self._lines, self._things
        if lines is None or things is None:
            return
        if estimate.shape is not None and self._filtered:
            self._confine(lines, things, estimate.shape)
        position = estimate.position
        if position is None or estimate.lost or self._blind:
            lines.locate(self.tick, position or STILL, inf)  # nothing is surely satisfied
            things.locate(position or STILL, inf)
        else:
            known = (position, estimate.bound, estimate.shape, self._body.swept)
            lines.locate(self.tick, *known)
            things.locate(*known)

    def _confine(self, lines: SeparatingLines, things: Things, shape: Polygon) -> None:
        """Cut off from the set of possible positions what workspace, obeyed lines and things exclude."""
        estimate = self._estimate
        for _ in range(CORNERS):
            edge = self._boundary.beyond(estimate.x, estimate.y, shape)
            if edge is None or not estimate.confine(edge, "the workspace"):
                break
            shape = estimate.shape or shape
        for peer, side in lines.crossed(estimate.x, estimate.y, shape):
            estimate.confine(side, f"the line with robot {peer}")
        for number, side in things.crossed(estimate.x, estimate.y, estimate.shape or shape):
            estimate.confine(side, f"thing {number}")

    def _on_roster(self, roster: Roster) -> None:
        """Follow a roster that may be a newer one."""
        news = self._roster.update(roster)
        for member in news:
            self._neighbours.on_member(member)
        if self._lines is None:
            own = self._roster.member(self.robot)
            if own is not None and own.radius != self._radius:  # an earlier life took up a part
                self._radii[self.robot] = self._radius = own.radius
                self._boundary = boundary_of(self._scenario.workspace.shape, self._radius)
            scenario, founding = self._scenario, self._roster.founding
            starts = {peer.id: peer.start for peer in scenario.robots}
            self._things = Things(
                self._radii[self.robot],
                scenario.shapes,
                starts[self.robot] if founding else None,
                speed=self._speed,
                period=scenario.time.step,
                reach=self._body.reach,
            )
            self._lines = SeparatingLines(
                self.robot,
                self.incarnation,
                self._radii,
                speed=self._speed,
                period=scenario.time.step,
                reach=self._body.reach,
                members=news,
                starts=starts if founding else None,
                urgent=urgent(scenario) if scenario.hears_near else None,
            )
            self._locate()
        else:
            for member in news:
                self._lines.on_member(member)
        if self._things is not None:
            self._things.follow(self._roster.things)

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
            gamma = (position[0] - self.goal[0]) ** 2 + (position[1] - self.goal[1]) ** 2
            slice_norm = self._law.slice_norm(position, self.goal)
            if self._filtered and self._lines is not None:
                proposals, answers = self._lines.entries(self._desired)
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
            None if self._mover is None else self._mover.claim,
        )

    # -- parts

    def _move_parts(self, mover: Mover, ordered: Vector | None) -> None:
        """Decide what to do about parts in this tick; who was ordered elsewhere leaves them alone."""
        position, heard = self._estimate.position, self._neighbours
        if position is None or self._lines is None:
            return
        mover.look(self.tick, position, self._roster, heard.heard(), list(heard.standing.values()), ordered)
        self.goal = mover.goal

    def _fit_to_load(self, mover: Mover, lines: SeparatingLines, things: Things) -> Handling | None:
        """Be the disk that parts need from this command on, a larger one only where there is room for it;
        what is asked for if that is so.

        It never is a smaller one than the roster says: that one stands if this robot falls silent.
        """
        own = self._roster.member(self.robot)
        told = self._radius if own is None else own.radius
        wanted, held = max(told, mover.radius), mover.held if told < mover.radius else 0
        is_kept = wanted <= self._radius and things.held in (0, held)
        if not (is_kept or told >= wanted or self._has_room(wanted, held, lines, things)):
            wanted, held = max(told, self._spec.radius), 0
        lines.wanted = mover.radius
        if (wanted, held) != (self._radius, things.held):
            self._resize(wanted, held, lines, things)
        return mover.handles if self._radius >= mover.radius else None

    def _has_room(self, radius: float, held: int, lines: SeparatingLines, things: Things) -> bool:
        """Whether a larger disk would satisfy all that is obeyed, thing `held` left out."""
        estimate, room = self._estimate, self._scenario.workspace.shape
        position = estimate.position
        if position is None or estimate.lost or self._blind or not (lines.ready and things.ready):
            return False
        swept = 0.0 if self._body.swept is None else self._body.reach
        inside = boundary_of(room, radius).contains(*position, estimate.bound + swept)
        return inside and lines.has_room(radius) and things.has_room(radius, held)

    def _resize(self, radius: float, held: int, lines: SeparatingLines, things: Things) -> None:
        things.resize(radius, held)
        if radius == self._radius:
            return
        self._radius = radius
        self._boundary = boundary_of(self._scenario.workspace.shape, radius)
        lines.resize(radius)
        sized = [
            replace(spec, radius=radius) if spec.id == self.robot else spec for spec in self._scenario.robots
        ]
        self._law = choose(replace(self._scenario, robots=tuple(sized)), self.robot)

    def reconsider(self, tick: Tick) -> None:
        """The same tick again: somebody who took part no longer does, and is not waited for."""
        self._awaited.intersection_update(tick.active)

    # -- between the phases

    def on_state(self, state: PeerState) -> None:
        """The State of a peer of this run has arrived."""
        robot, tick = state.robot, state.tick
        if self._open and tick <= self.tick and self._link.ideal and self._lines is not None:
            self._learn(self._lines, state)  # as `command` would in a moment
        else:
            self._link.put(state)
        if tick >= self.tick:
            self._awaited.discard(robot)
        if tick > self.tick and tick > self._ahead.get(robot, -1):
            self._ahead[robot] = tick

    def on_summary(self, summary: Summary) -> None:
        """The world says where everybody is, for a tick that begins soon.

        Raises:
            MessageError: it is not made as a summary is.
        """
        if self._picture is None or summary.tick > self._picture.tick:
            self._picture = FarPicture(summary, self._neighbours.radii, self._picture)

    def _on_letter(self, letter: State) -> None:
        """A far peer speaks by way of the world; the link's faults are between robots, however they speak."""
        radius = self._neighbours.radii.get(letter.robot)
        if radius is not None:
            self._link.put(addressed_to(self.robot, letter, radius, FAR))

    @property
    def complete(self) -> bool:
        """Whether the States of all whom this robot hears in this tick have arrived, and the summary due."""
        picture = self._picture
        return not self._awaited and (
            self._attention.due < 0 or (picture is not None and picture.tick >= self._attention.due)
        )

    @property
    def lacks_states(self) -> bool:
        """Whether States are missing."""
        return bool(self._awaited)

    @property
    def hears_everybody(self) -> bool:
        """Whether nobody has said who is near."""
        return self._attention.everybody

    # -- phase 2

    def command(self) -> Command:
        """Close the tick; returns the Command to publish."""
        self._open = False
        lines, things, position = self._lines, self._things, self._estimate.position
        velocity = self._desired = STILL
        handles: Handling | None = None
        letter: State | None = None
        if lines is not None:
            self._take_over(lines, self.tick)
            self._look_afar(lines)
            letter = self._letter(lines)  # before the velocity, which has to keep to all that is offered
            if not self._filtered or (lines.keeps_clear and things is not None and things.keeps_clear):
                self._kept = self._roster.version
            if self._mover is not None and things is not None:
                handles = self._fit_to_load(self._mover, lines, things)
            if position is not None and not self._halted:
                self._desired = self._wish(position)
                wish = lines.make_room(self._desired)
                if things is not None:
                    wish = things.make_room(wish)
                velocity = self._allowed(lines, position, wish)
        report = self._report() if self._reports else None
        return Command(
            self.robot, self.incarnation, self.tick, velocity, self._kept, (), report, letter, handles
        )

    def _report(self) -> Report | None:
        """Where this robot knows itself to be."""
        position = self._estimate.position
        return None if position is None or self._estimate.lost else Report(position, self._estimate.bound)

    def _look_afar(self, lines: SeparatingLines) -> None:
        """Take in the newest summary that is due, if it is news."""
        picture, position, due = self._picture, self._estimate.position, self._attention.due
        if picture is None or position is None or not self._painted < due <= picture.tick:
            return
        self._painted = picture.tick
        lines.survey(picture)
        neighbours = self._neighbours
        known = {self.robot, *self._attention.near, *neighbours.standing}
        radius = self._radii[self.robot]
        neighbours.far = picture.field(position, radius, known)

    def _letter(self, lines: SeparatingLines) -> State | None:
        """What is to be said to far peers, if anything."""
        if self._attention.everybody or not self._filtered:
            return None
        proposals, answers = lines.letters()
        if not proposals and not answers:
            return None
        estimate = self._estimate
        return State(
            self.robot,
            self.incarnation,
            self.tick,
            estimate.position,
            estimate.bound,
            0.0,
            0.0,
            STILL,
            proposals,
            answers,
        )

    def _wish(self, position: Vector) -> Vector:
        """The velocity that the law asks for; of a mover, straight to where it aims."""
        if self._turn is not None and not self._turn.has_come(self.tick):
            return STILL
        aim = None if self._mover is None else self._mover.aim
        if aim is None:
            return self._law.velocity(self._view(position))
        dx, dy = aim[0] - position[0], aim[1] - position[1]
        rate = min(self._control.speed / max(hypot(dx, dy), 1e-12), 1.0 / self._scenario.time.step)
        return rate * dx, rate * dy

    def _view(self, position: Vector) -> View:
        """What the law is given in this tick."""
        return View(
            tick=self.tick,
            position=position,
            goal=self.goal,
            displacement=self._moved,
            neighbours=self._neighbours,
            things=() if self._things is None else self._things.shapes,
        )

    def complaint(self) -> Command:
        """In place of a Command that cannot be given: whose States are missing."""
        lacking = tuple(sorted(self._awaited)[:NAMED])
        return Command(self.robot, self.incarnation, self.tick, STILL, self._kept, lacking)

    def _take_over(self, lines: SeparatingLines, tick: int) -> None:
        """Hear all States that are due by `tick`."""
        for state in self._link.take(tick):
            self._learn(lines, state)

    def _learn(self, lines: SeparatingLines, state: PeerState) -> None:
        if state.index == FAR:
            lines.on_letter(state)
        elif self._attention.counts(state.robot, state.tick):
            self._neighbours.on_state(state)
            lines.on_state(state)

    def _allowed(self, lines: SeparatingLines, position: Vector, desired: Vector) -> Vector:
        """The velocity nearest to the desired one that keeps to all lines, the workspace and the limit."""
        if not self._filtered:
            return desired
        things, estimate = self._things, self._estimate
        if things is None or not (lines.ready and things.ready) or estimate.lost or self._blind:
            return STILL
        half_planes = [*lines.half_planes(), *things.half_planes()]
        return self._body.velocity(desired, position, half_planes, self._boundary, estimate.shape)

    # -- about itself

    def has_ended(self, tick: Tick) -> bool:
        """Whether the world says that this incarnation is over."""
        roster = tick.roster
        return roster is not None and has_ended(roster, self.robot, self.incarnation)

    @property
    def scenario(self) -> Scenario:
        """The run, as this robot was told of it."""
        return self._scenario

    @property
    def lost(self) -> bool:
        """Whether what it was told of where it is cannot be true, so that it stands."""
        return self._estimate.lost

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
        lines = self._lines.obeyed_lines() if self._filtered and self._lines is not None else ()
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
