"""One run of a scenario in this process: all positions, and their digest."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import numpy as np

from deploy.run.local import LocalFleet
from protocol.codec import decode
from protocol.keys import world_key
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from tests.listening import overhear

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
    fleet, positions = LocalFleet(scenario), dict[int, tuple[Vector, ...]]()

    def note(key: str, payload: bytes) -> None:
        truth = decode(key, payload)
        positions[truth.tick] = truth.positions

    overhear(fleet.network, note, world_key(fleet.run, "truth"))
    report = fleet.execute()
    ticks = range(0, report["ticks"] + 1, EVERY)
    return Trajectory(report["trajectory_sha256"], report["ticks"], tuple(positions[tick] for tick in ticks))


def rounding() -> str:
    """Digest of how this machine rounds what runs use; digests of runs hold where it is equal."""
    x = np.random.default_rng(0).uniform(0.01, 10.0, 20_000)
    scalar = (math.exp, math.expm1, math.log, math.log1p, math.sin, math.cos, lambda a: math.hypot(a, 1.0))
    rows = [np.array([function(float(a)) for a in x]) for function in scalar]
    rows += [np.log(x), np.exp(-x), np.hypot(x, 1.0), np.random.default_rng(0).normal(size=len(x))]
    return hashlib.sha256(np.concatenate(rows).tobytes()).hexdigest()[:16]
