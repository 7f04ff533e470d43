"""What is measured of whole fleets is there and runs. Nothing is timed here."""

from __future__ import annotations

import pytest

from protocol.scenario.network import Network
from tests.benchmarks import __main__ as bench
from tests.benchmarks import links
from tests.benchmarks.fleets import Measured, measure


@pytest.mark.process
@pytest.mark.timeout(60)
def test_a_fleet_is_measured_over_several_runs() -> None:
    found = measure(2, 0.5)
    assert found.ticks_per_second > 0.0
    assert found.cpu_ms > 0.0
    assert 0.0 < found.start < 30.0
    assert found.private_mb > 0.1


def test_the_table_has_a_ratio_for_each() -> None:
    floor, fleet = bench.Rate(1000.0, 2.0), Measured(700.0, 4.0, 0.5, 5.0)
    floor_line, fleet_line = bench.table(6, {"bare zenoh": floor, "fleet": fleet}).splitlines()
    assert floor_line.split()[-5:] == ["1000", "1.00", "2.00", "1.00", "66.7"]
    assert fleet_line.split()[-7:] == ["700", "0.70", "4.00", "0.50", "133.3", "0.50", "5.0"]


def test_blocks_have_as_many_robots_each_and_stay_apart() -> None:
    scenario = links.in_blocks(24, 3, 1.0, Network("near"))
    at = links.homes(scenario, 3)
    assert sorted(at.values()) == [1] * 8 + [2] * 8 + [3] * 8
    starts = {spec.start: at[spec.id] for spec in scenario.robots}
    for order in scenario.orders:
        assert order.goal is not None
        assert {starts[point] for point in order.goal.points} == {at[order.goal.robot]}
