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
from protocol.line import ROUNDING, Line
from protocol.region import Region, RegionGeometry
from tests.agents.lines.models.skirmishes.skirmish import Skirmish
from tests.proof.link import Facts, Watch, broken, record, watched
from world.world import WorldCore

pytestmark = pytest.mark.skipif(ledgers.__file__.endswith(".so"), reason="only sources can be looked at")
PRODUCT: Any = SimpleNamespace(Robot=Robot, World=WorldCore, Line=Line)


class PlaneFacts(Facts):
    """What the plane says of a record; a body is the true disk."""

    def clear(self, a: Region, b: Region) -> bool:
        held: Any = SimpleNamespace(regions=[(0, a)])
        return RegionGeometry().clear(held, b)

    def inside(self, x: str, body: Shape, region: int) -> bool:
        known = self.regions[x].get(region)
        if known is None or known.is_everywhere or not isinstance(body, Disk):
            return known is not None
        around = known.shape.around
        gap = around.radius - Disk(around.x, around.y, 0.0).distance(body.x, body.y) - body.radius
        return gap >= -ROUNDING

    def shape(self, region: Region) -> Shape:
        return region.shape

    def fits(self, x: str, body: Shape, line: Line) -> bool:
        side = 1.0 if x == "A" else -1.0
        return body.support(side * line.nx, side * line.ny) <= side * line.offset + ROUNDING

    def disjoint(self, a: Shape, b: Shape) -> bool:
        """Bodies that stand where the run begins; the judge looks at all others."""
        return True


class Check:
    """Looks at two disks of a skirmish after each rule."""

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
        low, high = sorted(self._random.sample(there, 2))
        s = record(ledger, watch.processes, low, high)
        facts = PlaneFacts(ledger, low, high, s)
        for x, name in (("A", low), ("B", high)):
            s[f"{x}.body"] = s[f"{x}.own"] = self._body(name, facts.regions[x])
        return [f"{low}, {high}: {each}" for each in broken(s, facts)]

    def _body(self, name: int, held: dict[int, Region]) -> Shape:
        assert self.run is not None
        if name < 0:
            (place,) = held.values()
            return place.shape
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
