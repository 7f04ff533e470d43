"""Robots on wheels in a physics engine: nothing touches, by either judge, unless a rule is left out."""

import math
from dataclasses import replace

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'disknav[mujoco]'")

from protocol.scenario.body import PRESETS
from tests.world.plants.deviations import WHEELED, lacking
from tests.world.plants.fleet import Setting, drive
from world.plants.mujoco import Physics

# Late and lost States, lost commands, a sharp law and each at its own pace: a robot that relies on stopping
# at once touches.
HARD = Setting(robots=6, delay=0.3, loss=0.3, dropped=0.1, speed=0.2, k=200.0, pace="own", seed=0)
SLOW = replace(HARD, period=0.5)  # a body goes farther within a tick


@pytest.mark.campaign
def test_robots_that_take_their_bodies_for_points_touch_and_the_engine_agrees() -> None:
    report = drive(SLOW, naive=True)
    assert report["verdict"] == "collision"
    assert report["min_clearance"] < -0.01
    seen = {tuple(contact["pair"]) for contact in report["contacts"] if contact["deepest"] < -1e-3}
    assert seen <= {tuple(contact["pair"]) for contact in report["plant"]["contacts"]}


@pytest.mark.slow
@pytest.mark.parametrize("setting", [HARD, pytest.param(SLOW, marks=pytest.mark.campaign)])
def test_robots_that_know_their_bodies_do_not(setting: Setting) -> None:
    report = drive(setting)
    assert report["verdict"] == "arrived" or setting == SLOW
    assert report["min_clearance"] > 0.0
    assert (report["plant"]["kind"], report["plant"]["contacts"]) == ("mujoco", [])


@pytest.mark.slow
@pytest.mark.parametrize("period", [0.01, 0.1])
@pytest.mark.parametrize("name", WHEELED)
def test_bodies_keep_to_what_they_state(name: str, period: float) -> None:
    """The campaign `deviations` measures it for longer, and at other periods."""
    play, drift = lacking(PRESETS[name], period, 12)
    assert play < 0.0
    assert drift < 0.0


def test_a_servo_without_its_integral_part_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """The measurement sees what it has to."""
    monkeypatch.setattr("world.plants.mujoco._INTEGRAL", 0.0)
    assert lacking(PRESETS["turtlebot3-burger"], 0.2, 12).play > 0.0


def test_a_base_stands_only_once_its_wheels_do() -> None:
    plant = Physics(Setting(robots=2).scenario)
    for tick in range(20):
        plant.move({1: (0.1, 0.0)}, tick)
    while not plant.stands(0):
        tick += 1
        plant.move({}, tick)
    before = plant.positions[0]
    for _ in range(20):
        plant.move({}, tick)
    assert math.dist(before, plant.positions[0]) < 1e-5
