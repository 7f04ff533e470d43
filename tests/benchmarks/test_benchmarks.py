"""The benchmarks themselves: everything that they measure is there and runs. Nothing is timed here."""

from __future__ import annotations

from pathlib import Path

import pytest

from deploy.library.load import load
from protocol.scenario.model import Network
from tests.benchmarks import __main__ as bench
from tests.benchmarks import (
    cores,
    floors,
    journal,
    libraries,
    link_model,
    links,
    physics,
    reading,
    recording,
)
from tests.benchmarks.fleets import Measured, measure


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("carrier", ["zmq", "pipes"])
def test_floors_tick(carrier: floors.Carrier) -> None:
    if carrier == "zmq":
        pytest.importorskip("zmq")
    assert floors.rate(3, 0.1, carrier).ticks_per_second > 0.0


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


def test_all_cores_are_measured() -> None:
    found = cores.costs(3, repeat=1, number=2)
    assert list(found) == ["slice", "filter", "codec", "robot", "world"]
    assert all(cost.core > 0.0 and cost.floor > 0.0 for cost in found.values())


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("variant", recording.VARIANTS)
def test_who_records_or_watches_is_measured(variant: str) -> None:
    found = recording.cost(load("figure-1", ["time.limit=0.5"]), variant)
    assert found.ticks_per_second > 0.0
    assert found.cpu_ms > 0.0


@pytest.mark.process
@pytest.mark.timeout(60)
def test_the_journal_is_measured() -> None:
    found = journal.cost(2, 0.2, rounds=1)
    assert found.plain > 0.0
    assert found.ratio == found.journalled / found.plain
    assert journal.added(2, repeat=1) < 1e6
    assert journal.replay(2).size > 20.0


@pytest.mark.process
def test_libraries_are_measured() -> None:
    rows = [line.rsplit(maxsplit=3) for line in libraries.lines(2, 1000, 1)]
    assert [row[0].strip() for row in rows[4:]] == ["fork server", "multiprocessing", "interpreters"]
    assert all(float(number) > 0.0 for row in rows[4:] for number in row[1:])


@pytest.mark.process
def test_reading_is_measured(tmp_path: Path) -> None:
    count = reading.make(tmp_path / "any.mcap", 15.0, 3)
    assert count > 3 * 3 * 300
    assert reading.cost(tmp_path / "any.mcap", ("info",)).peak_mb > 10.0
    with pytest.raises(RuntimeError, match="exit status 2"):
        reading.cost(tmp_path / "none.mcap", ("info",))


@pytest.mark.process
def test_fleets_in_a_physics_engine_are_measured() -> None:
    pytest.importorskip("mujoco")
    found = physics.swap(2, "wheels in MuJoCo", limit=1.0)
    assert found.time == pytest.approx(1.0)
    assert min(found[:-1]) > 0.0
    floor = found._replace(time=0.5, path=2.0 * found.path)
    words = physics.line(6, "wheels in MuJoCo", found._replace(factor=12.3), floor).split()
    assert words[:6] == ["6", "wheels", "in", "MuJoCo", "12.3", "10"]
    assert [words[10], words[12]] == ["(2.00)", "(0.50)"]


def test_the_ratio_is_to_the_same_round() -> None:
    plain = [recording.Cost(400.0, 2.0), recording.Cost(100.0, 8.0)]
    recorded = [recording.Cost(360.0, 2.2), recording.Cost(90.0, 8.8)]
    _, line = recording.lines({"plain": plain, "recorded": recorded})
    assert line.split() == ["recorded", "225", "0.900", "5.50", "1.100"]


def test_blocks_have_as_many_robots_each_and_stay_apart() -> None:
    scenario = links.in_blocks(24, 3, 1.0, Network("near"))
    at = links.homes(scenario, 3)
    assert sorted(at.values()) == [1] * 8 + [2] * 8 + [3] * 8
    starts = {spec.start: at[spec.id] for spec in scenario.robots}
    for order in scenario.orders:
        assert order.goal is not None
        assert {starts[point] for point in order.goal.points} == {at[order.goal.robot]}


def test_a_model_of_links_is_found_again() -> None:
    loads = [link_model.load(links.in_blocks(12, hosts, 1.0, Network("near")), hosts) for hosts in (2, 3, 4)]
    found = link_model.fitted(loads, [each.bytes(200.0, 150.0) for each in loads])
    assert found == pytest.approx((200.0, 150.0))
