import itertools
import math

import numpy as np
import pytest
from mpmath import mp, mpf

from protocol.scenario.model import Control, Workspace
from tests.world.driving import scenario
from world.judge.clearance import Disks
from world.judge.goals import Goals
from world.judge.phi import NavigationFunction

RADIUS = 0.04


def exact(setting, positions):
    """Equations (4), (5), (9) in 60 digits, with nothing in logarithms."""
    mp.dps = 60
    specs, k = setting.robots, mpf(setting.k)
    points = [(mpf(z.real), mpf(z.imag)) for z in positions]
    gamma = sum((x - s.goal[0]) ** 2 + (y - s.goal[1]) ** 2 for (x, y), s in zip(points, specs, strict=True))
    beta = mpf(1)
    for (a, b), (c, d) in itertools.combinations(points, 2):
        beta *= (a - c) ** 2 + (b - d) ** 2 - mpf(2 * RADIUS) ** 2
    for x, y in points:
        beta *= mpf(setting.workspace.radius - RADIUS) ** 2 - x**2 - y**2
    return float((gamma**k / (gamma**k + beta)) ** (1 / k))


def spread(robots, seed, k):
    """Robots on a jittered grid, goals at random."""
    draw = np.random.default_rng(seed)
    side = math.ceil(math.sqrt(robots))
    grid = [complex(0.1 * (n % side), 0.1 * (n // side)) - complex(side, side) / 20 for n in range(robots)]
    jitter = draw.uniform(-0.005, 0.005, (robots, 2))
    goals = [(float(x), float(y)) for x, y in draw.uniform(-0.2, 0.2, (robots, 2))]
    setting = scenario(
        *[((0.0, 0.0), goal) for goal in goals],
        radius=RADIUS,
        control=Control(k=k),
        workspace=Workspace(0.1 * side + 0.2),
    )
    return setting, np.array(grid) + jitter[:, 0] + 1j * jitter[:, 1]


@pytest.mark.parametrize(
    ("robots", "k"), [(1, 2.0), (2, 5.0), (3, 20.0), (6, 60.0), (6, 1000.0), (20, 700.0), (6, 1e4)]
)
@pytest.mark.parametrize("seed", range(3))
def test_phi_equals_the_formula_in_many_digits(robots, k, seed):
    setting, positions = spread(robots, seed, k)
    (phi,) = NavigationFunction(Disks(setting), Goals(setting), setting.k)(positions[None])
    assert phi == pytest.approx(exact(setting, positions), rel=1e-10)


@pytest.mark.parametrize("robots", [2, 20, 70])
def test_phi_of_many_is_the_same(robots, monkeypatch):
    setting, positions = spread(robots, 0, 1e4)
    goals = Goals(setting)
    goals.points = positions + 0.01
    phi = NavigationFunction(Disks(setting), goals, setting.k)
    positions = np.array([positions, positions])
    positions[1, 0] = positions[1, -1] + RADIUS
    found = phi(positions)
    monkeypatch.setattr("world.judge.phi.FEW", 0)
    assert phi(positions) == pytest.approx(found, rel=1e-12)
    assert found[0] < found[1] == 1.0


def test_phi_is_finite_for_many_robots_and_a_large_gain():
    setting, positions = spread(200, 0, 1e4)
    (phi,) = NavigationFunction(Disks(setting), Goals(setting), setting.k)(positions[None])
    assert 0.0 < phi <= 1.0


def test_phi_is_0_at_the_goal_and_1_on_the_boundary_and_outside():
    setting = scenario(((0.0, 0.0), (0.1, 0.0)), ((0.0, 0.0), (-0.1, 0.0)))
    phi = NavigationFunction(Disks(setting), Goals(setting), setting.k)
    configurations = np.array(
        [[0.1, -0.1], [0.04, -0.04], [0.01, -0.01], [0.5, -0.1], [0.5, -0.5], [0.06, -0.06]], dtype=complex
    )
    *values, free = phi(configurations)
    assert values == [0.0, 1.0, 1.0, 1.0, 1.0]
    assert 0.0 < free < 1.0
    assert phi(configurations[-1:]) == [free]
