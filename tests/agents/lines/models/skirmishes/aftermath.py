"""Skirmishes that end: from then on every robot has a process, receives all States and wants to stay.

Nothing holds a robot then, so each has to become ready to move. Robots know exactly where they are here: two
that begin anew closer to each other than the bounds of their errors cannot agree on a line.
"""

from dataclasses import replace
from random import Random
from typing import Any

from protocol.scenario.model import Scenario
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.skirmishes import skirmish
from tests.agents.lines.models.skirmishes.arena import Staying

CALM = 80  # ticks


def violation_of(seed: int, product: Product) -> str:
    """The violation of the run with this seed, or the robots that stand for ever; "" if there are none."""
    run = Aftermath(seed, product)
    violation = skirmish.first_violation(run, skirmish.TICKS)
    if not violation:
        run.end()
        violation = skirmish.first_violation(run, CALM)
    return violation or run.standing()


class Aftermath(skirmish.Skirmish):
    """One run, all of it drawn from its seed; in every other one all processes end with the trouble."""

    def __init__(self, seed: int, product: Product) -> None:
        self._is_over, self._anew = False, seed % 2 == 0
        super().__init__(seed, product)

    def _drawn(self, seed: int, rng: Random) -> Scenario:
        return replace(super()._drawn(seed, rng), sensing=())

    def end(self) -> None:
        self._is_over = self.waits = True
        self.trouble = self.loss = 0.0
        self.delay, self.operator, self.former, self.late = 0, None, [], []
        for robot in self.scenario.ids:
            process = self.processes.get(robot)
            if process is None or self._anew:
                self.world.lost(robot)
                self._join(robot)
            self.processes[robot].asleep = 0
            self.processes[robot].core._law = Staying()

    def _live(self, process: Any, robot: int) -> None:
        super()._live(process, robot)
        if self._is_over:
            process.core._law = Staying()

    def standing(self) -> str:
        """Robots that are not ready to move; "" if all are."""
        cores = [process.core for process in self.processes.values()]
        held = sorted(core.robot for core in cores if not core._filter.lines.ready)
        return f"robots {held} stand for ever" if held else ""
