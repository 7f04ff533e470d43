"""Tightness, lengths, deviations, and phi against its formula in many digits."""

import itertools
import math

import numpy as np
import pytest
from mpmath import log10, mp, mpf

from protocol.scenario.model import Control, Workspace
from tests.world.driving import scenario
from world.judge.clearance import Disks
from world.judge.measures import Goals, levels_of, normalised_length, tight

RADIUS = 0.04


def at_goals(*goals):
    return scenario(*[((0.0, 0.0), goal) for goal in goals], radius=RADIUS)


def tightness(setting):
    return tight(Disks.of(setting), Goals.of(setting))


def test_tight_is_computed_in_centimetres():
    """Three robots of 4 cm with goals on a right triangle of 20, 15 and 25 cm."""
    product = (20**2 - 64) * (15**2 - 64) * (25**2 - 64)
    assert tightness(at_goals((0.0, 0.0), (0.2, 0.0), (0.0, 0.15))) == pytest.approx(
        100 / math.log10(product)
    )


@pytest.mark.parametrize(
    "goals",
    [((0.0, 0.0),), ((0.0, 0.0), (0.08, 0.0)), ((0.0, 0.0), (0.05, 0.0)), ((0.0, 0.0), (0.0805, 0.0))],
)
def test_tight_is_none_where_it_has_no_meaning(goals):
    assert tightness(at_goals(*goals)) is None


def test_normalised_length():
    setting = scenario(((0.0, 0.0), (0.3, 0.0)), ((0.1, 0.1), (0.1, 0.2)))
    assert normalised_length(Goals.of(setting), {1: 0.35, 2: 0.15}) == pytest.approx(0.5 / 0.4)
    assert normalised_length(Goals.of(at_goals((0.0, 0.0))), {1: 0.0}) is None


def test_deviation_is_the_distance_from_the_straight_way():
    goals = Goals.of(scenario(((0.0, 0.0), (0.2, 0.0)), ((0.0, 0.1), (0.0, 0.1))))
    places = np.array(
        [[0.1 + 0.03j, 0.01 + 0.1j], [0.15 - 0.02j, 0.1j], [-0.03 - 0.04j, 0.1j], [0.23 + 0.08j, 0.3j]]
    )
    found = goals.deviations(places)
    assert found[:, 0] == pytest.approx([0.03, 0.02, 0.05, np.hypot(0.03, 0.08)])
    assert found[:, 1] == pytest.approx([0.01, 0.0, 0.0, 0.2])


def judged(setting, positions):
    return levels_of(Disks.of(setting), Goals.of(setting), setting.k, positions)


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
    return float((gamma**k / (gamma**k + beta)) ** (1 / k)), float(log10(gamma**k / beta) / k)


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
def test_phi_and_its_logarithm_equal_the_formulas_in_many_digits(robots, k, seed):
    setting, positions = spread(robots, seed, k)
    (level,) = judged(setting, positions[None])
    assert level == pytest.approx(exact(setting, positions), rel=1e-10)


@pytest.mark.parametrize("robots", [2, 20, 70])
def test_phi_of_many_is_the_same(robots, monkeypatch):
    setting, positions = spread(robots, 0, 1e4)
    disks = Disks.of(setting)
    goals = Goals({n: ((0.0, 0.0), (at.real + 0.01, at.imag)) for n, at in enumerate(positions, 1)})
    positions = np.array([positions, positions])
    positions[1, 0] = positions[1, -1] + RADIUS
    found = levels_of(disks, goals, setting.k, positions)
    monkeypatch.setattr("world.judge.measures.FEW", 0)
    again = levels_of(disks, goals, setting.k, positions)
    assert np.array(again) == pytest.approx(np.array(found), rel=1e-12)
    assert found[0] < found[1] == (1.0, 300.0)


def test_phi_is_0_at_the_goal_and_1_on_the_boundary_and_outside():
    setting = scenario(((0.0, 0.0), (0.1, 0.0)), ((0.0, 0.0), (-0.1, 0.0)))
    configurations = np.array(
        [[0.1, -0.1], [0.04, -0.04], [0.01, -0.01], [0.5, -0.1], [0.5, -0.5], [0.06, -0.06]], dtype=complex
    )
    *values, free = judged(setting, configurations)
    assert values == [(0.0, -300.0), *[(1.0, 300.0)] * 4]
    assert 0.0 < free.phi < 1.0
