"""Robots on wheels in a physics engine: nothing touches, by either judge, unless a rule is left out."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'disknav[mujoco]'")

from tests.world.plants.fleet import Setting, drive
from world.plants.physics import Physics

# Late and lost States, lost commands, a sharp law and each at its own pace: who relies on stopping at once
# touches.
HARD = Setting(robots=6, delay=0.3, loss=0.3, dropped=0.1, speed=0.2, k=200.0, pace="own", seed=0)


@pytest.mark.slow
def test_robots_that_take_their_bodies_for_points_touch_and_the_engine_agrees() -> None:
    report = drive(HARD, naive=True)
    assert report["verdict"] == "collision"
    assert report["min_clearance"] < -0.01
    seen = {tuple(contact["pair"]) for contact in report["contacts"] if contact["deepest"] < -1e-3}
    assert seen <= {tuple(contact["pair"]) for contact in report["plant"]["contacts"]}


@pytest.mark.slow
def test_robots_that_know_their_bodies_do_not() -> None:
    report = drive(HARD)
    assert report["verdict"] == "arrived"
    assert report["min_clearance"] > 0.0
    assert (report["plant"]["kind"], report["plant"]["contacts"]) == ("mujoco", [])


@pytest.mark.slow
def test_the_same_run_twice_is_the_same() -> None:
    setting = Setting(robots=4, noise=0.003, heading=0.03, dropped=0.1, seed=3)
    one, other = drive(setting), drive(setting)
    assert one["trajectory_sha256"] == other["trajectory_sha256"]
    assert one["verdict"] == "arrived"


def test_a_base_that_hears_nothing_stops_where_it_said() -> None:
    plant = Physics(Setting(robots=2).scenario)
    for tick in range(20):
        plant.move({1: (0.1, 0.0)}, tick)
    stop, (x, y), speed = plant.report(0).stop, plant.positions[0], math.hypot(*plant.report(0).velocity)
    assert stop is not None
    assert not plant.stands(0)
    for tick in range(20, 40):
        plant.move({}, tick)
    assert plant.stands(0)
    body = Setting().scenario.body_of(1)
    off = math.dist(plant.positions[0], (x + stop[0], y + stop[1]))
    assert off <= body.error * math.hypot(*stop) + body.lag * speed + body.play
    assert plant.lengths[0] > 0.05
    assert plant.lengths[1] < 1e-3


def test_encoders_say_how_far_it_went_but_for_slip() -> None:
    plant = Physics(Setting(robots=2).scenario)
    body = Setting().scenario.body_of(1)
    for tick in range(60):
        before = plant.positions[0]
        plant.move({1: (0.1 if tick % 40 < 20 else -0.1, 0.05)}, tick)
        after, said = plant.positions[0], plant.report(0).displacement
        off = abs(complex(after[0] - before[0] - said[0], after[1] - before[1] - said[1]))
        assert off <= body.odometry * abs(complex(*said)) + body.drift


def test_a_plant_needs_a_period_that_it_can_part() -> None:
    from protocol.errors import UsageError
    from protocol.scenario.model import Time

    scenario = replace(Setting(robots=2).scenario, time=Time(step=0.033))
    with pytest.raises(UsageError, match=r"steps of 0\.01 s"):
        Physics(scenario)
