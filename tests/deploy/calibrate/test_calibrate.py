"""Calibration against a base whose errors are known: what it says covers them, and is not far above."""

import math
import random
import tomllib
from dataclasses import replace
from unittest.mock import Mock

import pytest

from deploy.calibrate import Calibration, MeasuredBounds, bounds, square, statements
from deploy.library.load import load
from protocol.bus.bus import Bus, Publish
from protocol.bus.local import LocalNetwork
from protocol.errors import BusError
from protocol.scenario.body import Base
from tests.agents.bases.wheels import STEP, Wheels
from tests.forks import Forks
from tests.proxy import Proxy

LATENCY, TIMEOUT, NOISE = 0.04, 0.3, 0.008


def telling(tell: Publish) -> Bus:
    """A bus on which `tell` takes all commands."""
    return Proxy(LocalNetwork().connect(), raw_publisher=lambda *_: tell)


def measured(scale: float = 1.0, seed: int = 0) -> MeasuredBounds:
    """Of a base that is `scale` times as good an odometer as it could be, in virtual time."""
    settings = ["world.plant=external", f"base.timeout={TIMEOUT}", "sensing.noise=0.003"]
    scenario = load("turtlebots-2", [*settings, f"sensing.noise_bound={NOISE}", "sensing.heading=0.03"], 1)
    wheels = Wheels(scenario, 1, random.Random(seed))
    wheels.scale = scale
    table = replace(scenario.base_of(1), latency=LATENCY).of(1)
    sent: list[tuple[float, bytes]] = []
    now = 0.0
    bus = telling(lambda payload: sent.append((now + LATENCY, payload)))
    driver = Calibration(bus, table, square(0.6, 0.15, 0.8), 1.0)
    heard: list[tuple[float, str, bytes]] = []
    for step in range(round(200.0 / STEP)):
        now = step * STEP
        while sent and sent[0][0] <= now:
            wheels.on_message(sent.pop(0)[1], now)
        while heard and heard[0][0] <= now:
            _, key, payload = heard.pop(0)
            driver.on_message(key, payload, now)
        wheels.roll(now)
        if step % 4 == 0:
            heard.append((now + LATENCY, driver.topics[0], wheels.odometry(now).serialize()))
        if step % 10 == 0:
            heard.append((now + LATENCY, driver.topics[1], wheels.pose(now).serialize()))
        if now >= driver.deadline:
            driver.on_timer(now)
        if driver.finished:
            break
    assert driver.finished
    return bounds(driver.log)


@pytest.fixture(scope="module")
def found():
    return measured()


@pytest.mark.slow
def test_what_is_late_is_measured(found):
    assert 2 * LATENCY < found.lag < 2 * LATENCY + 0.1
    assert TIMEOUT < found.timeout < TIMEOUT + 2 * LATENCY + 0.15
    assert found.interval == pytest.approx(0.02, abs=0.006)
    assert found.acceleration == pytest.approx(0.66, rel=0.3)


def test_poses_at_rest_say_how_far_they_scatter(found):
    assert 0.5 * NOISE < found.noise_bound < 1.5 * NOISE
    assert 0.01 < found.heading < 0.05


@pytest.mark.slow
def test_odometry_that_is_off_is_found_out(found):
    worse = measured(1.07)
    assert worse.odometry == pytest.approx(0.07, abs=0.03)
    assert worse.odometry > found.odometry + 0.03


def test_what_is_to_be_stated_is_toml_and_has_a_margin(found):
    said = tomllib.loads(statements(found))
    assert said["base"]["timeout"] >= 1.5 * found.timeout
    assert said["body"]["acceleration"] <= found.acceleration / 1.5
    assert said["body"]["lag"] >= 1.5 * found.lag
    assert said["sensing"]["noise_bound"] >= 1.5 * found.noise_bound


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        *("node robot 1 --run yard --base ros2", "node world turtlebots-2 --set world.plant=external"),
        *("run turtlebots-2 --keep --set world.plant=external", "run turtlebots-2 --set base.tools=true"),
    ],
)
def test_a_secured_router_would_let_nothing_of_a_base_pass(disknav: Forks, line: str) -> None:
    done = disknav(*line.split(), "--secure", "keys")
    assert done.returncode == 2
    assert "--secure cannot apply" in done.stderr
    assert "a router without keys" in " ".join(done.stderr.split())


def test_nothing_is_told_before_the_base_and_its_localisation_speak():
    tell = Mock()
    driver = Calibration(telling(tell), Base().of(1), square(0.5, 0.1, 0.5), 1.0)
    driver.on_timer(0.0)
    tell.assert_not_called()
    with pytest.raises(BusError, match="no message on bot1/odom and bot1/pose"):
        driver.on_timer(math.inf)
