"""What is measured of fleets and their robots is there and runs. Nothing is timed here."""

import pytest

from deploy.run.options import RunOptions
from tests.benchmarks.crowds import measure, restless
from tests.benchmarks.obstacles import Fleet
from tests.benchmarks.steps import crowd, step


@pytest.mark.process
@pytest.mark.timeout(60)
def test_a_fleet_is_measured_over_several_runs() -> None:
    found = measure(restless(2), RunOptions(), 0.5)
    assert min(found.ticks_per_second, found.cpu_ms, found.start) > 0.0
    assert found.memory > 100.0


def test_what_robots_spend_on_messages_is_counted() -> None:
    assert step(crowd(2, "reciprocal", 0.0), 1) > 0.0
    fleet = Fleet(3, 2, 3)
    fleet.step()
    assert fleet.whole > fleet.robots > [0.0]
