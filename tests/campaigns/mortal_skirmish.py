"""Skirmishes whose world dies at any message, and is followed by another that goes on from its checkpoint."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from random import Random
from types import SimpleNamespace
from typing import Any

import msgspec

from agents.robot import Robot
from protocol.errors import JoinError
from protocol.messages import Command, Tick
from protocol.scenario.model import Operation, Scenario
from protocol.scenario.network import Burst, Distance, Link, Roaming
from tests.agents.lines.models.skirmishes.skirmish import Skirmish, first_violation
from tests.campaigns.campaign import Campaign, Dice, Outcome
from world.world import Past, WorldCore

TICKS = 70
_RATES = (5e-5, 3e-4, 1e-3)  # probability of death at a message
_OFTEN = 10  # as probable, at whatever happens once a tick
_PRODUCT: Any = SimpleNamespace(Robot=Robot, World=WorldCore)


class _Death(BaseException):
    """kill -9, at this very operation."""


class _MortalWorld:
    """A world that may die before and after all that it is asked for, and hears its own epoch only."""

    def __init__(self, world: WorldCore, skirmish: MortalSkirmish) -> None:
        self._world, self._skirmish, self._epoch = world, skirmish, skirmish.epoch

    def __getattr__(self, name: str) -> Any:
        return getattr(self._world, name)

    def accept(self, command: Command) -> bool:
        self._skirmish.pass_by()
        accepted = command.epoch == self._epoch and self._world.accept(command)
        self._skirmish.pass_by()
        return accepted

    def close_tick(self) -> None:
        self._skirmish.pass_by(_OFTEN)
        self._world.close_tick()
        self._skirmish.pass_by(_OFTEN)

    def operate(self, operation: Operation) -> Any:
        self._skirmish.pass_by(_OFTEN)
        reply = self._world.operate(operation)
        self._skirmish.pass_by(_OFTEN)
        self._skirmish.save()  # before it is answered
        self._skirmish.pass_by(_OFTEN)
        return reply


class MortalSkirmish(Skirmish):
    """One run, all of it drawn from its seed.

    Attributes:
        epoch: of the world that lives.
    """

    def __init__(self, seed: int) -> None:
        self.epoch = 1
        self._doom, self._saved = Random(f"doom {seed}"), b""
        self._rate = self._doom.choice(_RATES)
        super().__init__(seed, _PRODUCT)
        self.world = _MortalWorld(self.world, self)

    def _drawn(self, seed: int, rng: Random) -> Scenario:
        scenario, draw = super()._drawn(seed, rng), Random(f"link {seed}")
        if draw.random() < 0.3:
            return scenario
        link = Link(
            delay=draw.choice((0.0, (0.0, 0.3))),
            jitter=draw.choice((0.0, 0.1)),
            loss=draw.choice((0.0, 0.2)),
            duplicate=draw.choice((0.0, 0.5)),
            capacity=draw.choice((None, 40.0, 100.0)),
            burst=draw.choice((None, Burst(0.5, 0.3, (0.0, 0.2), 0.5))),
            roaming=draw.choice((None, Roaming(1.0, (0.1, 0.4)))),
            distance=draw.choice((None, Distance(0.05, 0.5, 2.0))),
        )
        return replace(scenario, link=link)

    def pass_by(self, times: int = 1) -> None:
        """The world dies now, once in a while.

        Raises:
            _Death: it does.
        """
        if self._saved and self._doom.random() < self._rate * times:
            raise _Death

    def save(self) -> None:
        """Keep the checkpoint from which the next world goes on."""
        self._saved = msgspec.msgpack.encode(self.world.past)

    def tick(self) -> None:
        for robot, process in list(self.processes.items()):
            if process.core.epoch != self.epoch and process.asleep <= 0 and self._doom.random() < 0.5:
                try:
                    self._live(process, robot)
                except JoinError:  # its world has not begun, or has no place for it: it asks again
                    continue
        try:
            super().tick()
        except _Death:
            self._succeed()

    def _succeed(self) -> None:
        self.epoch += 1
        world = WorldCore(self.scenario, msgspec.msgpack.decode(self._saved, type=Past))
        self.world = _MortalWorld(world, self)
        self.before = list(world.truth.positions)
        for process in self.processes.values():
            process.asleep -= 1

    def _live(self, process: Any, robot: int) -> None:
        super()._live(process, robot)
        process.core.epoch = self.epoch
        if self._saved:
            self.save()

    def _tell(self, told: Mapping[int, Tick]) -> None:
        self.pass_by(_OFTEN)
        if self.world.is_open or self._saved:
            self.save()
        self.pass_by(_OFTEN)
        for robot, tick in told.items():
            self.pass_by(2)
            super()._tell({robot: msgspec.structs.replace(tick, epoch=self.epoch)})
            process = self.processes.get(robot)
            if process is not None and process.queue and self._doom.random() < 0.05:
                process.queue.append(process.queue[-1])

    def _open(self, process: Any) -> None:
        process.queue = deque(tick for tick in process.queue if tick.epoch == process.core.epoch)
        super()._open(process)


def _run(dice: Dice) -> Outcome:
    run = MortalSkirmish(dice.seed)
    violation = first_violation(run, TICKS)
    ready = [bool(each.core._filter.lines.ready) for each in run.processes.values()]
    figures = {"deaths": run.epoch - 1.0, "robots with lines at the end": float(sum(ready))}
    return Outcome("violated" if violation else "held", violation, figures=figures)


SKIRMISH = Campaign(_run, 5_000)
