import math

import pytest

from agents.law.deadlock import PATIENCE, Progress, barred, circling
from agents.peers.state import Peer


def still(progress: Progress, seconds: float, **changes: object) -> float:
    tick = {
        "displacement": (0.0, 0.0),
        "desired": (0.1, 0.0),
        "free": 0.1,
        "gamma": 0.2,
        "barred": lambda: False,
    }
    strength = 0.0
    for _ in range(round(seconds / progress.period)):
        strength = progress.update(**(tick | changes))
    return strength


def test_lines_that_block_are_noticed_by_what_was_really_executed() -> None:
    progress = Progress(0.05)
    assert still(progress, 0.9 * PATIENCE) == 0.0
    assert 0.0 < still(progress, 0.4) < 1.0
    assert still(progress, 1.0) == 1.0
    assert still(progress, 0.5, displacement=(0.005, 0.0)) < 1.0
    assert still(progress, 2.0, displacement=(0.005, 0.0)) == 0.0


@pytest.mark.parametrize("period", [0.01, 0.05, 0.5])
@pytest.mark.parametrize("lap", [0.02, 0.4, 10.0])
def test_swinging_every_other_tick_is_no_progress_at_any_period(period: float, lap: float) -> None:
    progress, strengths = Progress(period, lap), list[float]()
    for tick in range(max(400, round(10 * lap / period))):
        swing = -1.0 if tick % 2 else 1.0
        there = {"displacement": (swing * period, 0.0), "desired": (swing, 0.0), "free": 1.0}
        strengths.append(still(progress, period, barred=lambda: True, **there))
    assert max(strengths) == 1.0


def test_a_robot_nudged_off_its_goal_waits_while_gamma_falls() -> None:
    progress, gamma = Progress(0.05), 1.0
    for _ in range(200):
        gamma *= 0.99
        assert still(progress, progress.period, desired=(0.0, 0.0), gamma=gamma) == 0.0
    assert still(progress, 3.0, desired=(0.0, 0.0), gamma=gamma) == 1.0


def test_members_of_a_cluster_circle_in_one_sense() -> None:
    angles = [0.3 + 2 * math.pi * n / 5 for n in range(5)]
    places = [(0.07 * math.cos(a), 0.07 * math.sin(a)) for a in angles]
    for i, (x, y) in enumerate(places):
        peers = [Peer(*place, 0.04, 0.0) for j, place in enumerate(places) if j != i]
        assert circling((x, y), (0.0, 0.0), 0.04, peers) == pytest.approx((y / 0.07, -x / 0.07))


def test_only_a_disk_on_the_way_bars_it() -> None:
    way = ((-0.2, 0.0), (0.2, 0.0), 0.04)
    assert barred(*way, [Peer(0.0, 0.07, 0.04, 0.0)])
    assert not barred(*way, [Peer(0.0, 0.09, 0.04, 0.0), Peer(-0.25, 0.0, 0.04, 0.0)])
