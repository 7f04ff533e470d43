import math

from hypothesis import given
from hypothesis import strategies as st

from protocol.scenario.body import Actuation as ActuationFaults
from protocol.scenario.model import Control
from tests.world.driving import STEP, two
from world.plants.integrator import SimulatedPoint, limited

component = st.floats(-1e300, 1e300) | st.floats(-1.0, 1.0)


@given(component, component, st.floats(1e-3, 10.0))
def test_the_speed_limit_is_exact(x, y, speed):
    vx, vy = limited((x, y), speed)
    assert math.hypot(vx, vy) <= speed
    if math.hypot(x, y) <= speed:
        assert (vx, vy) == (x, y)
    else:
        assert math.isclose(math.hypot(vx, vy), speed, rel_tol=1e-12)
        assert math.isclose(math.atan2(vy, vx), math.atan2(y, x), rel_tol=1e-9, abs_tol=1e-9)


def test_a_velocity_without_a_length_is_none():
    assert limited((1.7e308, 1.7e308), 0.1) == (0.0, 0.0)
    assert limited((math.nan, 0.0), 0.1) == (0.0, 0.0)


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.integers(0, 10**6), st.integers(0, 2**63 - 1))
def test_actuation_noise_keeps_its_bound_and_the_speed_limit(x, y, tick, seed):
    setting = two(actuation=ActuationFaults(noise=0.3), control=Control(k=60.0, speed=0.1), seed=seed)
    asked = limited((x, y), 0.1)
    ((dx, dy),) = SimulatedPoint(setting, 1).move((x, y), tick)
    assert math.hypot(dx, dy) <= 0.1 * STEP * (1 + 1e-15)
    off = math.hypot(dx - asked[0] * STEP, dy - asked[1] * STEP)
    assert off <= setting.actuation.bound * math.hypot(*asked) * STEP * (1 + 1e-12)
