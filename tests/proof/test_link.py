"""Robots, world and coordinator take only the kernel's rules, and keep the invariant that was proved."""

from __future__ import annotations

from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from agents.robot import Robot
from protocol.geometry import Disk, Shape
from protocol.kernel import ledger as ledgers
from protocol.kernel.records import GONE
from protocol.line import Line
from tests.agents.lines.models.skirmishes.skirmish import Skirmish
from tests.proof.link import Facts, Watch, watched
from world.world import WorldCore

pytestmark = pytest.mark.skipif(ledgers.__file__.endswith(".so"), reason="only sources can be looked at")
PRODUCT: Any = SimpleNamespace(Robot=Robot, World=WorldCore, Line=Line)


class Check:
    """Looks at a robot and another disk of a skirmish after each rule."""

    def __init__(self, seed: int) -> None:
        self.run: Skirmish | None = None
        self._random = Random(seed)

    def __call__(self, watch: Watch, rule: str) -> list[str]:
        if self.run is None or not watch.ledgers:
            return []
        ledger = watch.ledgers[-1]
        there = sorted(name for name, disk in ledger.disks.items() if disk.phase != GONE)
        if len(there) < 2:
            return []
        robot = self._random.choice([name for name in there if name > 0])
        low, high = sorted((robot, self._random.choice([name for name in there if name != robot])))
        facts = Facts(ledger, watch.processes, low, high)
        for x, name in (("A", low), ("B", high)):
            body = self._body(name, ledger.disks[name].held.regions[0][1].shape)
            facts.s |= {f"{x}.body": body, f"{x}.own": body}
        return [f"{low}, {high}: {each}" for each in facts.broken()]

    def _body(self, name: int, place: Shape) -> Shape:
        """The true disk of a robot; an obstacle is its place."""
        assert self.run is not None
        if name < 0:
            return place
        x, y = self.run.world.simulation.places[name]
        return Disk(x, y, self.run.scenario.spec(name).radius)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_a_skirmish_takes_only_rules_and_keeps_the_invariant(seed: int) -> None:
    check = Check(seed)
    with watched(Watch(check)) as watch:
        check.run = run = Skirmish(seed, PRODUCT)
        for _ in range(40):
            run.tick()
            assert run.violation() == ""
    assert watch.wrong == []
    assert watch.taken.total() > 100
