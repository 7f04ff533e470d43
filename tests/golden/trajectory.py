"""One run of a scenario in this process: all positions, and their digest."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field

import numpy as np

from deploy.run.local import LocalFleet
from protocol.bus.bus import Event, Sample
from protocol.codec import decode
from protocol.keys import world_key
from protocol.messages import Truth, Vector
from protocol.scenario.model import Scenario

EVERY = 10  # ticks between two configurations that are kept


@dataclass(frozen=True)
class Trajectory:
    """`positions`: m, in the order of ids, at every tick that is a multiple of `EVERY`, from tick 0 on."""

    sha256: str
    ticks: int
    positions: tuple[tuple[Vector, ...], ...]

    def deviation(self, other: Trajectory) -> float:
        """Largest distance of a robot from where it is in the other at the same tick, m, while both last."""
        pairs = list(zip(self.positions, other.positions, strict=False))
        return max(math.dist(a, b) for one, two in pairs for a, b in zip(one, two, strict=True))


def run(scenario: Scenario) -> Trajectory:
    fleet = LocalFleet(scenario)
    bus = fleet.network.connect()
    bus.subscribe(world_key(fleet.run, "truth"))
    listener = bus.node = _Listener()
    report = fleet.execute()
    ticks = range(0, report["ticks"] + 1, EVERY)
    return Trajectory(
        report["trajectory_sha256"], report["ticks"], tuple(listener.positions[tick] for tick in ticks)
    )


@dataclass
class _Listener:
    finished: bool = False
    deadline: float = math.inf
    positions: dict[int, tuple[Vector, ...]] = field(default_factory=dict)

    def handle(self, event: Event) -> None:
        if isinstance(event, Sample):
            truth = decode(event.key, event.payload)
            assert isinstance(truth, Truth)
            self.positions[truth.tick] = truth.positions

    def wake(self, now: float) -> None:
        """Nothing is due by the wall clock."""


def rounding() -> str:
    """Digest of how this machine rounds what runs use; digests of runs hold where it is equal."""
    x = np.random.default_rng(0).uniform(0.01, 10.0, 20_000)
    scalar = (math.exp, math.expm1, math.log, math.log1p, math.sin, math.cos, lambda a: math.hypot(a, 1.0))
    rows = [np.array([function(float(a)) for a in x]) for function in scalar]
    rows += [np.log(x), np.exp(-x), np.hypot(x, 1.0), np.random.default_rng(0).normal(size=len(x))]
    return hashlib.sha256(np.concatenate(rows).tobytes()).hexdigest()[:16]
