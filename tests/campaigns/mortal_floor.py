"""Random lives of external bases, in virtual time, whose robots want to touch: worlds die and are followed by
others, processes freeze or die, odometry fails, obstacles come, messages are late, lost and repeated."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from random import Random
from typing import Any

import msgspec

from agents.bases.ros2 import Ros2Base
from agents.robot import Robot
from protocol.errors import JoinError
from protocol.messages import Command, Tick
from protocol.scenario.model import Obstacle, Operation, Scenario
from tests.agents.bases.floor import Crew, Event, Floor
from tests.agents.bases.test_senses import fleet
from tests.agents.lines.models.skirmishes.arena import Staying
from tests.campaigns.campaign import Campaign, Dice, Outcome
from world.past import Past
from world.world import WorldCore

SECONDS = 20.0
_ROUNDING = 1e-9  # m
_SETTINGS = ("time.deadlock=1000", "time.endless=true")


def drawn(draw: Random) -> Scenario:
    settings = (
        f"control.speed={draw.choice((0.1, 0.2, 0.22))}",
        f"world.lease={draw.choice((0.31, 0.5, 0.8))}",
        f"time.fence={draw.choice((0.2, 1.0))}",
    )
    return fleet(draw.choice((2, 3, 4)), *_SETTINGS, *settings)


class _Attack(Staying):
    """Drives at where another robot truly is, and changes its mind now and then."""

    def __init__(self, floor: MortalFloor, robot: int) -> None:
        self._floor, self._robot, self._target = floor, robot, robot

    def velocity(self, view: Any) -> tuple[float, float]:
        draw, scenario = self._floor.draw, self._floor.scenario
        if self._target == self._robot or draw.random() < 0.03:
            self._target = draw.choice([each for each in scenario.ids if each != self._robot])
        x, y = self._floor.crews[self._target].wheels.control
        dx, dy = x - view.position[0], y - view.position[1]
        scale = scenario.control.speed / (math.hypot(dx, dy) or 1.0)
        return scale * dx, scale * dy


class MortalFloor(Floor):
    """A floor on which all that happens is drawn from a seed.

    Attributes:
        epoch: of the world that lives, or lived last.
        gap: m, the smallest so far between a disk and an obstacle or the wall.
    """

    def __init__(self, seed: int) -> None:
        self.draw = draw = Random(f"floor {seed}")
        self.epoch, self.gap = 0, math.inf
        self._dead, self._saved = False, b""  # whether no world lives, and its checkpoint
        self._gone: set[int] = set()  # robots without a process
        self._mute: dict[int, float] = {}  # robot -> until when its odometry is lost
        self._slow = draw.choice((0.0, 0.0, 0.02, 0.1))  # share of messages that are late by seconds
        scenario, delay, loss = drawn(draw), draw.choice((0.02, 0.05, 0.2)), draw.choice((0.0, 0.1, 0.3))
        super().__init__(scenario, seed, delay=delay, loss=loss, odometry=self._said)
        for crew in self.crews.values():
            self._begin_life(crew, crew.core)
        for _ in range(draw.randint(3, 10)):
            self._later(draw.uniform(2.0, 16.0), self._happen)

    def _said(self, robot: int, now: float, message: Any) -> Any:
        return None if now < self._mute.get(robot, 0.0) else message

    def _begin_life(self, crew: Crew, core: Robot) -> None:
        core._law = _Attack(self, core.robot)
        crew.core = core

    # -- what happens

    def _happen(self) -> None:
        robot = self.draw.choice(self.scenario.ids)
        happenings: tuple[Callable[[int], None], ...] = (
            *(self._world_dies, self._world_dies, self._world_dies, self._freeze, self._die),
            *(self._lose_odometry, self._lose_odometry, self._cut_off, self._halt, self._place, self._place),
        )
        self.draw.choice(happenings)(robot)
        if self.draw.random() < 0.3:
            self._later(self.draw.uniform(0.0, 0.4), self._happen)

    def _world_dies(self, robot: int) -> None:
        if self._dead or not self._saved:
            return
        self._dead = True
        if self.draw.random() < 0.5:
            self._later(self.draw.uniform(0.0, 0.6), partial(self._lose_odometry, robot, 6.0))
        self._later(self.draw.choice((0.0, 0.05, 0.3, 1.0)), self._another_world)

    def _another_world(self) -> None:
        """It goes on from what was kept before anything was told; robots join one by one."""
        self._dead = False
        self.epoch += 1
        self.world = WorldCore(self.scenario, msgspec.msgpack.decode(self._saved, type=Past))
        for robot in self.scenario.ids:
            self._later(
                self.draw.choice((0.0, 0.05, 0.1, 0.5, 1.5)), partial(self._rejoin, robot, self.epoch)
            )
        if self.draw.random() < 0.2:
            self._later(self.draw.uniform(0.0, 0.5), partial(self._world_dies, self.scenario.ids[0]))

    def _freeze(self, robot: int) -> None:
        crew = self.crews[robot]
        if crew.alive:
            crew.alive = False
            self._later(self.draw.uniform(0.05, 2.5), lambda: crew.alive or self.thaw(robot))

    def _die(self, robot: int) -> None:
        """The process ends; another for the same base comes later, and joins once its senses are sound."""
        if robot in self._gone:
            return
        crew = self.crews[robot]
        self._gone.add(robot)
        crew.frozen, crew.alive = [], False
        self._later(self.draw.uniform(0.2, 3.0), partial(self._is_born, crew))

    def _is_born(self, crew: Crew) -> None:
        robot = crew.core.robot
        crew.frozen, crew.alive, crew.swept = [], True, None
        crew.base = Ros2Base(self.scenario, robot, self.scenario.base_of(robot))
        self._come(crew)

    def _come(self, crew: Crew) -> None:
        if crew.alive and crew.base.senses.place() is not None and self._join(crew):
            self._gone.discard(crew.core.robot)
        else:
            self._later(0.2, partial(self._come, crew))

    def _lose_odometry(self, robot: int, most: float = 3.0) -> None:
        self._mute[robot] = self.now + self.draw.uniform(0.05, most)

    def _cut_off(self, _: int) -> None:
        self.cut = True
        self._later(self.draw.uniform(0.1, 2.0), lambda: setattr(self, "cut", False))

    def _halt(self, _: int) -> None:
        self._operate(Operation(halt=True))
        self._later(self.draw.uniform(0.1, 3.0), lambda: self._operate(Operation(halt=False)))

    def _place(self, robot: int) -> None:
        x, y = self.crews[robot].wheels.control
        angle, away = self.draw.uniform(0.0, math.tau), self.draw.uniform(0.15, 0.4)
        centre = (x + away * math.cos(angle), y + away * math.sin(angle))
        if not self._dead and self.world.lives.founded:
            self._operate(Operation(place=Obstacle(center=centre, radius=0.02)))
            if self.draw.random() < 0.5:
                self._later(self.draw.uniform(0.0, 0.2), partial(self._world_dies, robot))

    def _operate(self, operation: Operation) -> None:
        if not self._dead:
            self.world.operate(operation)
            self._save()

    def _save(self) -> None:
        self._saved = msgspec.msgpack.encode(self.world.past)

    # -- lives under several worlds

    def _rejoin(self, robot: int, epoch: int) -> None:
        crew = self.crews[robot]
        if epoch != self.epoch or robot in self._gone:
            return
        if not crew.alive:
            crew.frozen.append(partial(self._rejoin, robot, epoch))
            return
        self._publish(crew, crew.base.stand(self.now))
        self._join(crew)

    def _join(self, crew: Crew) -> bool:
        robot, world = crew.core.robot, self.world
        if self._dead:
            return False
        world.lost(robot)
        try:
            incarnation = world.join(robot)
        except JoinError:
            return False
        self._begin_life(crew, Robot(self.scenario, robot, incarnation, lockstep=False, epoch=self.epoch))
        return True

    def _open(self) -> dict[int, Tick]:
        if self._dead:
            return {}
        told = super()._open()
        if not self.world.is_open:
            for robot in self.world.lives.awaited:
                self.world.give_up_waiting(robot)
            told = super()._open()
        self._save()
        return {robot: msgspec.structs.replace(tick, epoch=self.epoch) for robot, tick in told.items()}

    def _begin(self, crew: Crew, tick: Tick) -> None:
        if crew.core.robot not in self._gone and tick.epoch == crew.core.epoch:
            super()._begin(crew, tick)

    def _accept(self, command: Command) -> None:
        if not self._dead and command.epoch == self.epoch:
            super()._accept(command)

    def _send(self, event: Event) -> None:
        if self.rng.random() >= self.loss:
            late = self.draw.random() < self._slow
            delay = self.draw.uniform(0.3, 4.0) if late else self.rng.uniform(0.0, self.delay)
            self._later(delay, event)
            if self.draw.random() < 0.02:
                self._later(delay + self.draw.uniform(0.0, 2.0), event)

    def _roll(self) -> None:
        super()._roll()
        obstacles = {} if self._dead else self.world.lives.obstacles.standing
        for robot, crew in self.crews.items():
            x, y = crew.wheels.control
            radius = self.scenario.spec(robot).radius
            distances = [-self.scenario.workspace.shape.distance(x, y)]
            distances += [shape.distance(x, y) for shape in obstacles.values()]
            self.gap = min(self.gap, min(distances) - radius)


def _run(dice: Dice) -> Outcome:
    floor = MortalFloor(dice.seed)
    floor.run(SECONDS)
    faults = (
        (floor.closest < -_ROUNDING, f"two disks overlap by {-floor.closest:.3g} m"),
        (floor.gap < -_ROUNDING, f"a disk overlaps an obstacle or the wall by {-floor.gap:.3g} m"),
        (floor.excess > 0.0, f"a true place is {floor.excess:.3g} m outside what its robot knows"),
    )
    figures = {"worlds": floor.epoch + 1.0, "clearance, m": floor.closest, "to others, m": floor.gap}
    violation = "; ".join(text for wrong, text in faults if wrong)
    return Outcome("violated" if violation else "held", violation, figures=figures)


FLOOR = Campaign(_run, 2_000)
