import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from agents.law.flow import Flow, desired_velocity
from agents.law.gradient import Slice
from agents.peers.state import Peer
from deploy.library.load import load
from deploy.theory.exact_flow import random_configuration
from tests.benchmarks.theory.sampled import pair

PERIOD, SPEED = 0.05, 0.1


def crowd(seed: int, k: float = 60.0) -> tuple[Slice, tuple[float, float]]:
    rng = np.random.default_rng(seed)
    drawn = random_configuration(rng, np.full(7, 0.04), 0.30)
    places = [(x, y) for x, y in drawn.tolist()]
    peers = [Peer(*place, 0.04, float(rng.uniform(0.0, 0.04))) for place in places[2:]]
    return Slice(places[1], 0.04, 0.30, k, peers), places[0]


@pytest.mark.parametrize("seed", range(4))
def test_the_end_is_that_of_an_exact_integration(seed: int) -> None:
    field, start = crowd(seed)
    scale = SPEED / field.norm(*start)
    vx, vy = desired_velocity(Flow(field, scale), start, period=PERIOD, speed=1.0)
    exact = solve_ivp(
        lambda _, y: [-scale * d for d in field(*y)], (0, PERIOD), start, "LSODA", rtol=1e-10, atol=1e-13
    ).y[:, -1]
    error = math.hypot(start[0] + vx * PERIOD - exact[0], start[1] + vy * PERIOD - exact[1])
    assert error < 0.02 * SPEED * PERIOD


@pytest.mark.parametrize("k", [5.0, 60.0, 10_000.0])
@pytest.mark.parametrize("gap", [-0.01, 1e-12, 1e-9, 1e-6, 1e-3])
def test_never_faster_than_the_limit_nor_into_a_disk(k: float, gap: float) -> None:
    field = Slice((0.2, 0.0), 0.04, 0.30, k, [Peer(0.0, 0.0, 0.04, 0.01)])
    x, y = -0.08 - gap, 0.0
    for _ in range(40):
        before = math.hypot(x, y)
        vx, vy = desired_velocity(Flow(field, 10.0), (x, y), period=PERIOD, speed=SPEED)
        assert math.hypot(vx, vy) <= SPEED * (1 + 1e-12)
        x, y = x + vx * PERIOD, y + vy * PERIOD
        assert math.hypot(x, y) > min(before, 0.08)
    assert math.hypot(x, y) > 0.08
    rest = desired_velocity(Flow(field, 10.0), (x, y), period=PERIOD, speed=SPEED)
    assert math.hypot(*rest) < 0.02 * SPEED


@pytest.mark.slow
def test_the_sampled_fleet_keeps_to_the_path_of_the_exact_flow() -> None:
    settings = ["control.filter=none", 'control.additions=["pace"]']
    sampled, exact = np.mean([pair(load("figure-3d", settings, seed)) for seed in range(4)], axis=0)
    assert sampled == pytest.approx(exact, rel=0.05)
