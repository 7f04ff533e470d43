"""A floor with real bases, in virtual time: nothing on it knows of this project's models of them.

Everything that is sent takes a random time.
"""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import count

from agents.bases.ros2 import Ros2Base
from agents.bases.ros_messages import NANO, Odometry, StampedPose
from agents.lines.own_set import DIRECTIONS
from agents.peers.state import addressed_to
from agents.robot import Robot
from protocol.bodies.sweep import Sweep
from protocol.messages import Command, State, Tick
from protocol.scenario.model import Scenario
from tests.agents.bases.wheels import EPOCH, STEP, Vector, Wheels
from world.world import WorldCore

Event = Callable[[], None]


@dataclass
class Crew:
    """One robot's process."""

    core: Robot
    base: Ros2Base
    wheels: Wheels
    alive: bool = True  # the process
    frozen: list[Event] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    truths: dict[int, Vector] = field(default_factory=dict)  # of the control point, m, by ms
    swept: tuple[Vector, Sweep | None] | None = None  # from where, and what; None: it stands


class Floor:
    """A coordinator, its robots, their bases, and a network between them.

    Args:
        scenario: of an external fleet.
        seed: of all delays and losses.
        delay: s that a message of the fleet takes at most; those of a base take its `latency` at most.
        loss: share of the fleet's messages that are lost.
        odometry: changes what a base says, by robot, time and message; None loses it.
        pose: the same of a localisation.
        held_up: s, by which the link from a base to its robot is slower than usual, by robot and time.
    """

    def __init__(
        self,
        scenario: Scenario,
        seed: int = 0,
        *,
        delay: float = 0.03,
        loss: float = 0.0,
        odometry: Callable[[int, float, Odometry], Odometry | None] = lambda _r, _t, m: m,
        pose: Callable[[int, float, StampedPose], StampedPose | None] = lambda _r, _t, m: m,
        held_up: Callable[[int, float], float] = lambda _r, _t: 0.0,
    ) -> None:
        self.now = 0.0
        self.rng = random.Random(seed)
        self.scenario, self.delay, self.loss = scenario, delay, loss
        self.world = WorldCore(scenario)
        self.late = 0  # robot whose Ticks are held back
        self.held: list[Event] = []  # those
        self.cut = False  # whether nothing passes between coordinator and robots
        self.closest = math.inf  # m, smallest gap between any two disks so far
        self.excess = -math.inf  # m, by which a truth was outside the set that its robot knew
        self.strayed = -math.inf  # m, by which wheels left what their filter counts on
        self._events: list[tuple[float, int, Event]] = []
        self._number = count()
        self._odometry, self._pose, self._held_up = odometry, pose, held_up
        self._arrives = dict.fromkeys(scenario.ids, 0.0)  # s, when the last message of each base does
        self.crews: dict[int, Crew] = {}
        for robot in scenario.ids:
            core, base = Robot(scenario, robot, self.world.join(robot)), scenario.base_of(robot)
            self.crews[robot] = Crew(core, Ros2Base(scenario, robot, base), Wheels(scenario, robot, self.rng))
            self._wake(robot)
            self._later(self.rng.randrange(20) * 1e-3, lambda robot=robot: self._speak(robot))
            self._later(self.rng.randrange(50) * 1e-3, lambda robot=robot: self._locate(robot))
        self._later(0.0, self._roll)
        self._later(1.0, self._tick)

    def run(self, until: float) -> Floor:
        """Go on, until a time or the end of the run."""
        while self._events and self._events[0][0] <= until and not self.world.verdict:
            self.now, _, event = heapq.heappop(self._events)
            event()
        return self

    def release(self) -> None:
        """What was held back arrives, one after another."""
        for number, event in enumerate(self.held):
            self._later(0.05 * number, event)
        self.late, self.held = 0, []

    def moving(self) -> list[int]:
        """Robots whose wheels turn."""
        return [
            r for r, crew in self.crews.items() if max(abs(crew.wheels.left), abs(crew.wheels.right)) > 1e-3
        ]

    # -- time

    def _later(self, delay: float, event: Event) -> None:
        heapq.heappush(self._events, (self.now + delay, next(self._number), event))

    def _roll(self) -> None:
        for crew in self.crews.values():
            crew.wheels.roll(self.now)
        places = [(crew.wheels.control, crew.core.robot) for crew in self.crews.values()]
        for n, (place, robot) in enumerate(places):
            for other, peer in places[:n]:
                radii = self.scenario.spec(robot).radius + self.scenario.spec(peer).radius
                self.closest = min(self.closest, math.dist(place, other) - radii)
        if round(self.now / STEP) % 4 == 0:
            for crew in self.crews.values():
                self._stray(crew)
        self._later(STEP, self._roll)

    def _stray(self, crew: Crew) -> None:
        if crew.swept is None:
            return
        (x, y), sweep = crew.swept
        dx, dy = crew.wheels.control[0] - x, crew.wheels.control[1] - y
        for nx, ny in DIRECTIONS:
            allowed = 0.0 if sweep is None else sweep.extent(nx, ny)
            self.strayed = max(self.strayed, nx * dx + ny * dy - allowed)

    # -- the bases

    def _speak(self, robot: int) -> None:
        crew = self.crews[robot]
        crew.truths[round(self.now * 1000)] = crew.wheels.control
        message = (
            None if crew.wheels.dead else self._odometry(robot, self.now, crew.wheels.odometry(self.now))
        )
        if message is not None:
            self._to_robot(crew, lambda payload=message.serialize(): self._hear(crew, 0, payload))
        self._later(0.02, lambda: self._speak(robot))

    def _locate(self, robot: int) -> None:
        crew = self.crews[robot]
        message = self._pose(robot, self.now, crew.wheels.pose(self.now))
        if message is not None:
            self._to_robot(crew, lambda payload=message.serialize(): self._hear(crew, 1, payload))
        self._later(0.05, lambda: self._locate(robot))

    def _hear(self, crew: Crew, number: int, payload: bytes) -> None:
        crew.base.on_message(crew.base.topics[number], payload, self.now)

    def _to_robot(self, crew: Crew, event: Event) -> None:
        robot = crew.core.robot
        arrives = self.now + 0.5 * self.scenario.base_of(robot).latency + self._held_up(robot, self.now)
        self._arrives[robot] = max(self._arrives[robot], arrives)  # in order, as a link has it
        self._later(self._arrives[robot] - self.now, lambda: self._if_alive(crew, event))

    def _if_alive(self, crew: Crew, event: Event) -> None:
        if crew.alive:
            event()
        else:
            crew.frozen.append(event)

    def thaw(self, robot: int) -> None:
        """A process that was stopped goes on with all that it has missed."""
        crew = self.crews[robot]
        crew.alive, events, crew.frozen = True, crew.frozen, []
        for event in events:
            event()

    def _wake(self, robot: int) -> None:
        crew = self.crews[robot]
        if crew.alive and self.now >= crew.base.due:
            self._publish(crew, crew.base.on_timer(self.now))
            if crew.base.senses.fault != (crew.notes[-1] if crew.notes else None):
                crew.notes.append(crew.base.senses.fault)
        self._later(0.005, lambda: self._wake(robot))

    def _publish(self, crew: Crew, payload: bytes) -> None:
        latency = self.scenario.base_of(crew.core.robot).latency
        self._later(self.rng.uniform(0.0, latency), lambda: crew.wheels.on_message(payload, self.now))

    # -- the fleet

    def _send(self, event: Event) -> None:
        if self.rng.random() >= self.loss:
            self._later(self.rng.uniform(0.0, self.delay), event)

    def _tick(self) -> None:
        for robot, tick in self._open().items():
            crew = self.crews[robot]
            begin = partial(self._if_alive, crew, partial(self._begin, crew, tick))
            if robot == self.late:
                self.held.append(begin)
            elif not self.cut:
                self._send(begin)
        self._later(self.scenario.time.step, self._tick)

    def _open(self) -> dict[int, Tick]:
        """What the coordinator tells as the next tick opens."""
        if self.world.is_open:
            self.world.close_tick()
        return {} if self.world.verdict else self.world.open_tick()

    def _join(self, crew: Crew) -> bool:
        """Begin another life, if the coordinator admits it now."""
        crew.core = Robot(self.scenario, crew.core.robot, self.world.join(crew.core.robot))
        return True

    def _begin(self, crew: Crew, tick: Tick) -> None:
        core, base = crew.core, crew.base
        if core.has_ended(tick):
            self._publish(crew, base.stand(self.now))
            self._join(crew)
            return
        if tick.tick <= core.tick or tick.incarnation != core.incarnation:
            return
        sense = base.begin(tick, self.now)
        if base.senses.take_reset():
            core.reset_estimate()
        elif core.lost and not base.senses.fault:
            base.senses.invalidate(core.note)
        state = core.begin(tick, sense)
        if sense is not None and state.position is not None and not base.senses.fault:
            self._check(crew, state)
        for peer in self.crews.values():
            if peer is not crew:
                self._send(lambda peer=peer: self._if_alive(peer, lambda: self._deliver(peer, state)))
        command = core.command()
        self._publish(crew, base.obey(command, self.now))
        crew.swept = None if sense is None or base.senses.fault else self._swept(crew, command)
        if not self.cut:
            self._send(lambda: self._accept(command))

    def _swept(self, crew: Crew, command: Command) -> tuple[Vector, Sweep | None]:
        """From where the newest odometry is, what its filter takes the base to pass."""
        newest, body = crew.base.senses._odometer.newest, crew.core._body
        moves = command.velocity != (0.0, 0.0) or body.swept is not None
        truth = crew.truths[round((newest.stamp - EPOCH / NANO) * 1000)]
        return truth, body._passed(command.velocity) if moves else None

    def _deliver(self, peer: Crew, state: State) -> None:
        radius = self.scenario.spec(state.robot).radius
        peer.core.inbox.on_state(addressed_to(peer.core.robot, state, radius))

    def _accept(self, command: Command) -> None:
        if not self.cut:
            self.world.accept(command)

    def _check(self, crew: Crew, state: State) -> None:
        """The truth of when the newest odometry was said is in the set that the robot knows."""
        newest = crew.base.senses._odometer.newest
        truth = crew.truths[round((newest.stamp - EPOCH / NANO) * 1000)]
        self.excess = max(self.excess, math.dist(state.position, truth) - state.bound)
