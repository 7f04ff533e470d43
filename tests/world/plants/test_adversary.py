"""A law that wants a touch has none, with any body, at any period: a share of the campaign `adversary`."""

from dataclasses import replace
from importlib.util import find_spec
from itertools import cycle

import pytest

from tests.world.plants.fleet import BODIES, PERIODS, drive, hostile


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "period"), [*zip(cycle(["omnidirectional", "e-puck"]), PERIODS, strict=False)]
)
def test_in_formulas_with_errors_at_their_worst(body: str, period: float) -> None:
    report = drive(hostile(body, period, "integrator", seed=0, ticks=40))
    assert report["min_clearance"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "period"), [*zip(sorted(set(BODIES) - {"omnidirectional"}), cycle(PERIODS), strict=False)]
)
def test_in_mujoco(body: str, period: float) -> None:
    if find_spec("mujoco") is None:
        pytest.skip("MuJoCo is not installed: pip install 'disknav[mujoco]'")
    report = drive(hostile(body, period, "mujoco", seed=0, ticks=40))
    assert report["min_clearance"] > 0.0
    assert report["plant"]["contacts"] == []


def test_but_has_one_where_a_body_states_less_than_its_errors() -> None:
    stated = BODIES["omnidirectional"]
    less = replace(stated, lag=0.2 * stated.lag, play=0.0)
    setting = hostile("omnidirectional", 0.05, "integrator", seed=1, ticks=80)
    assert drive(setting)["min_clearance"] > 0.0
    assert drive(setting, stated=less)["min_clearance"] < 0.0
