"""One mover at a time: it descends the navigation function in its slot, though others are disturbed."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet
from protocol.scenario.model import Sensing
from world.report import result_of

SCENARIO = load("in-turn-3")
TICKS = SCENARIO.ticks(1.0)


def run(disturbed: tuple[int, ...]) -> tuple[LocalFleet, list[set[int]], list[float]]:
    """The fleet at its end, the robots that moved in each tick, and phi at the start of each.

    Args:
        disturbed: slots at whose end a standing robot is put 3 mm nearer to the middle.
    """
    sensing = (Sensing(contradiction="newest"),)  # a robot carried elsewhere believes its measurement
    fleet = LocalFleet(replace(SCENARIO, sensing=sensing))
    world, moved, heights = fleet.world.world, list[set[int]](), list[float]()
    while True:
        before = world.truth
        heights.append(before.phi)
        if not fleet.step():
            return fleet, moved, heights
        after = world.truth.positions
        moved.append(
            {robot for robot, b, a in zip(before.robots, before.positions, after, strict=True) if a != b}
        )
        turn, over = divmod(world.tick, TICKS)
        if over == 0 and turn in disturbed:
            mover = (turn - 1) % len(SCENARIO.ids)
            _push(fleet, (mover + 1) % len(SCENARIO.ids))


def _push(fleet: LocalFleet, index: int) -> None:
    positions = fleet.world.world.simulation.plant.positions
    x, y = positions[index]
    away = math.hypot(x, y)
    positions[index] = x - 0.003 * x / away, y - 0.003 * y / away


@pytest.mark.slow
def test_one_moves_at_a_time_and_phi_descends_though_static_robots_are_disturbed() -> None:
    turns = (2, 4)
    fleet, moved, heights = run(turns)
    pushed = {turn * TICKS + off for turn in turns for off in (-1, 0)}
    for tick in set(range(len(moved))) - pushed:
        assert moved[tick] <= {SCENARIO.ids[tick // TICKS % len(SCENARIO.ids)]}
    assert {tick for tick, (b, a) in enumerate(pairwise(heights)) if a > b + 1e-12} <= pushed
    report = result_of(fleet.world.world)
    assert (report["verdict"], report["collisions"]) == ("arrived", 0)
    assert sum(map(bool, moved)) > 3 * TICKS
