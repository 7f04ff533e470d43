"""Robots and world change the kernel's objects only by its rules, and keep the proved invariant."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from agents.robot import Robot
from protocol.geometry import Disk
from protocol.kernel import ledger as ledgers
from protocol.kernel.ledger import Ledger, Pair
from protocol.kernel.pair import Follower, Owner
from protocol.kernel.records import GONE, Binding, DiskRecord, End, Held
from protocol.kernel.robot import OwnEnd, RobotLife
from protocol.line import Line
from tests.agents.lines.models.skirmishes.skirmish import Skirmish
from tests.proof.link import Facts
from tests.proof.prove import RULES
from world.world import WorldCore

pytestmark = pytest.mark.skipif(ledgers.__file__.endswith(".so"), reason="only sources can be observed")
PRODUCT: Any = SimpleNamespace(Robot=Robot, World=WorldCore, Line=Line)
KEPT = (Ledger, Pair, DiskRecord, Held, Binding, End, RobotLife, OwnEnd, Owner, Follower)


class Watch:
    """Observes a skirmish: after every rule it checks the invariant for a robot and another disk.

    Attributes:
        run: the skirmish, once it has begun.
        executed: number of rules.
        wrong: violations of the invariant, and assignments outside of rules.
    """

    def __init__(self, seed: int, patch: pytest.MonkeyPatch) -> None:
        self.run: Skirmish | None = None
        self.executed = 0
        self.wrong: list[str] = []
        self._random, self._depth = Random(seed), 0
        self._ledger: Ledger[Any, Any] | None = None  # the newest
        self._processes: dict[tuple[int, int], RobotLife[Any, Any, Any]] = {}

        def write(made: Any, field: str, value: Any) -> None:
            if not self._depth:
                self.wrong.append(f"{type(made).__name__}.{field} is assigned outside of rules")
            object.__setattr__(made, field, value)

        for kind in KEPT:
            for name in ("__init__", *RULES.get(kind.__name__, "").split()):
                patch.setattr(kind, name, self._watched(kind, name))
            patch.setattr(kind, "__setattr__", write)

    def _watched(self, kind: type, name: str) -> Callable[..., Any]:
        """A rule or an `__init__` under observation."""
        does = getattr(kind, name)

        @wraps(does)
        def done(made: Any, *args: Any, **kwargs: Any) -> Any:
            self._depth += 1
            try:
                result = does(made, *args, **kwargs)
            finally:
                self._depth -= 1
            if isinstance(made, Ledger):
                self._ledger = made
            elif isinstance(made, RobotLife):
                self._processes[made.name, made.life] = made
            if name != "__init__" and not self._depth:
                self.executed += 1
                self.wrong += [f"{kind.__name__}.{name}: {each}" for each in self._broken()]
            return result

        return done

    def _broken(self) -> list[str]:
        ledger = self._ledger
        there = [] if ledger is None else [disk.name for disk in ledger.disks.values() if disk.phase != GONE]
        if self.run is None or ledger is None or len(there) < 2:
            return []
        robot = self._random.choice([name for name in there if name > 0])
        low, high = sorted((robot, self._random.choice([name for name in there if name != robot])))
        facts = Facts(ledger, self._processes, low, high)
        for x, name in (("A", low), ("B", high)):
            body = ledger.disks[name].held.regions[0][1].shape  # of an obstacle
            if name > 0:
                x_y, radius = self.run.world.simulation.places[name], self.run.scenario.spec(name).radius
                body = Disk(*x_y, radius)
            facts.s |= {f"{x}.body": body, f"{x}.own": body}
        return [f"{low}, {high}: {each}" for each in facts.broken()]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_a_skirmish_executes_only_rules_and_keeps_the_invariant(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = Watch(seed, monkeypatch)
    watch.run = run = Skirmish(seed, PRODUCT)
    for _ in range(40):
        run.tick()
        assert run.violation() == ""
    assert watch.wrong == []
    assert watch.executed > 100
