"""A whole fleet in one process, without network, world or filter: all compute, then all move."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from agents.law.deadlock import Progress, barred, circling
from agents.law.flow import Flow, desired_velocity
from agents.law.gradient import Slice
from agents.law.pace import common_pace, max_rate
from agents.peers.state import Peer

SPEED, TOLERANCE = 0.1, 0.005


@dataclass
class Fleet:
    """`delay` is the age of the peers' states in ticks."""

    positions: list
    goals: list
    radii: list
    workspace: float
    k: float
    pace: str = "common"
    period: float = 0.05
    delay: int = 0
    escapes: bool = False
    clearance: float = math.inf
    lengths: float = 0.0
    time: float = 0.0
    escaping: int = 0
    _heard: list = field(default_factory=list)

    def __post_init__(self) -> None:
        self.positions = [(float(x), float(y)) for x, y in self.positions]
        self.goals = [(float(x), float(y)) for x, y in self.goals]
        self.radii = [float(r) for r in self.radii]
        self._straight = sum(map(math.dist, self.positions, self.goals))
        self._progress = [Progress(self.period) for _ in self.goals]
        self._displacements = [(0.0, 0.0)] * len(self.goals)

    @property
    def nrl(self) -> float:
        return self.lengths / self._straight

    @property
    def arrived(self) -> bool:
        return max(map(math.dist, self.positions, self.goals)) < TOLERANCE

    def run(self, limit: float) -> bool:
        while not self.arrived and self.time < limit:
            self.tick()
        return self.arrived

    def tick(self) -> None:
        gammas = [math.dist(b, g) ** 2 for b, g in zip(self.positions, self.goals, strict=True)]
        seen = self._heard[-1] if self._heard else (self.positions, gammas, None)
        norms = [self._slice(i, seen).norm(*b) for i, b in enumerate(self.positions)]
        self._heard.append((self.positions, gammas, norms))
        seen = self._heard[max(0, len(self._heard) - 1 - self.delay)]
        velocities = [self._velocity(i, seen) for i in range(len(self.goals))]
        self._displacements = [(vx * self.period, vy * self.period) for vx, vy in velocities]
        after = [
            (x + dx, y + dy) for (x, y), (dx, dy) in zip(self.positions, self._displacements, strict=True)
        ]
        self.clearance = min(self.clearance, self._closest(after))
        self.lengths += sum(math.hypot(*d) for d in self._displacements)
        self.positions = after
        self.time += self.period

    def _peers(self, i: int, seen: tuple) -> list[Peer]:
        return [Peer(*b, self.radii[j], seen[1][j]) for j, b in enumerate(seen[0]) if j != i]

    def _slice(self, i: int, seen: tuple) -> Slice:
        return Slice(self.goals[i], self.radii[i], self.workspace, self.k, self._peers(i, seen))

    def _velocity(self, i: int, seen: tuple) -> tuple[float, float]:
        own, here, goal = self._slice(i, seen), self.positions[i], self.goals[i]
        scale = max_rate(SPEED, self.period, TOLERANCE)
        error = math.dist(here, goal)
        if self.pace == "common":
            slices = [own.norm(*here) if j == i else norm for j, norm in enumerate(seen[2])]
            scale = common_pace(max(slices), max(*seen[1], error**2), SPEED, scale)
        wanted = desired_velocity(Flow(own, scale), here, period=self.period, speed=SPEED)
        return self._escape(i, seen, own, scale, wanted) if self.escapes else wanted

    def _escape(
        self, i: int, seen: tuple, own: Slice, scale: float, wanted: tuple[float, float]
    ) -> tuple[float, float]:
        here, goal, peers = self.positions[i], self.goals[i], self._peers(i, seen)
        error = math.dist(here, goal)
        free = 0.0 if error < TOLERANCE else min(SPEED, 2.0 * scale * error)
        strength = self._progress[i].update(
            displacement=self._displacements[i],
            desired=wanted,
            free=free,
            gamma=own.gamma(*here),
            barred=lambda: barred(here, goal, self.radii[i], peers),
            latency=self.delay * self.period,
        )
        if strength == 0.0:
            return wanted
        self.escaping += 1
        ux, uy = circling(here, goal, self.radii[i], peers)
        drift = (strength * free * ux, strength * free * uy)
        return desired_velocity(Flow(own, scale, drift), here, period=self.period, speed=SPEED)

    def _closest(self, after: list) -> float:
        """Smallest gap between any two disks while all move straight from one place to the next."""
        start, way = np.array(self.positions), np.array(after) - np.array(self.positions)
        i, j = np.triu_indices(len(start), 1)
        apart, closing = start[i] - start[j], way[i] - way[j]
        square = np.maximum((closing**2).sum(1), 1e-300)
        when = np.clip(-(apart * closing).sum(1) / square, 0.0, 1.0)
        gaps = (
            np.hypot(*(apart + when[:, None] * closing).T) - np.array(self.radii)[i] - np.array(self.radii)[j]
        )
        return float(gaps.min())


def scattered(rng: np.random.Generator, n: int, radius: float, workspace: float) -> np.ndarray:
    """Random centres of n equal disks that do not overlap."""
    while True:
        placed: list[np.ndarray] = []
        for _ in range(200 * n):
            spot = rng.uniform(-workspace, workspace, 2)
            if np.hypot(*spot) < workspace - radius - 0.002 and all(
                np.hypot(*(spot - other)) > 2 * radius + 0.002 for other in placed
            ):
                placed.append(spot)
            if len(placed) == n:
                return np.array(placed)


def tight_goals(rng: np.random.Generator, target: float) -> np.ndarray:
    """Six goals of disks of radius 0.04 in 0.30, drawn together until `tight` reaches the target."""
    i, j = np.triu_indices(6, 1)
    while True:
        goals = scattered(rng, 6, 0.04, 0.30)
        for shrink in np.linspace(1.0, 0.3, 300):
            gaps = 1e4 * (((goals[i] - goals[j]) ** 2).sum(1) * shrink**2 - 0.08**2)
            if (gaps <= 0.0).any():
                break
            if 100.0 / np.log10(gaps).sum() >= target:
                return goals * shrink
