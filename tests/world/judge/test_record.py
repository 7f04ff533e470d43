"""What a record measures, also when fleet, goals or obstacles change; contacts, and a trajectory's digest."""

import math
import struct

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import Disk
from protocol.scenario.model import Control, Obstacle, RobotSpec, Scenario, Workspace
from tests.world.driving import advance, joined, scenario, two
from world.judge.record import PastRecord, Record, trajectory_rows
from world.report import result_of

BOX = ((-0.05, 0.1), (0.05, 0.1), (0.05, 0.2), (-0.05, 0.2))
ROOM = ((-1.0, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.0, 0.5))


def crossing() -> Scenario:
    """One robot that is driven through a box and a disk, and into a wall."""
    return Scenario(
        (RobotSpec(3, 0.04, (-0.5, 0.15), (0.5, -0.3)),),
        workspace=Workspace(points=ROOM),
        control=Control(k=60.0),
        obstacles=(Obstacle(points=BOX), Obstacle(center=(0.4, 0.15), radius=0.05)),
    )


def test_contacts_name_the_obstacle_or_the_wall():
    setting = crossing()
    record = Record(setting, [(-0.5, 0.15)])
    for place in ((0.0, 0.15), (0.5, 0.15), (0.98, 0.15), (0.97, 0.15), (0.97, 0.15)):
        record.add([place])
    contacts = {contact.pair: contact for contact in record.totals.contacts}
    assert set(contacts) == {(-1, 3), (-2, 3), (0, 3)}
    box = contacts[(-1, 3)]
    assert math.isclose(box.begin, (0.5 - 0.09) / 0.5, abs_tol=1e-6)
    assert math.isclose(box.end, 1.0 + 0.09 / 0.5, abs_tol=1e-6)
    assert math.isclose(box.deepest, -0.09, abs_tol=1e-9)
    assert math.isclose(contacts[(0, 3)].deepest, -0.02, abs_tol=1e-9)
    assert math.isclose(record.totals.clearance, -0.09, abs_tol=1e-9)


def test_a_touch_within_a_tick_is_found_when_and_where_it_was() -> None:
    setting = two()
    record = Record(setting, [(-0.1, 0.1), (-0.1, -0.1)], parts=2)
    record.add([(-0.1, 0.1), (-0.1, -0.1)], [((-0.1, 0.01), (-0.1, -0.01))])
    record.add([(-0.1, 0.1), (-0.1, -0.1)], [((-0.1, 0.1), (-0.1, -0.1))])
    (contact,) = record.totals.contacts
    assert record.totals.clearance == pytest.approx(-0.06)
    assert contact.deepest == pytest.approx(-0.06)
    assert 0.25 < contact.begin < 0.5 < contact.end < 0.75
    assert record.totals.truth.tick == 2
    assert [truth.tick for truth in record.news()] == [0, 1, 2]
    assert record.totals.truth.clearance == pytest.approx(0.26 - 0.1 * 2.0**0.5)  # to the boundary


def test_what_changes_counts_from_the_newest_configuration_on():
    record = Record(scenario(((0.0, 0.0), (0.2, 0.0))), [(0.0, 0.0)])
    record.add([(0.1, 0.01)])
    record.set_goal(1, (-0.1, 0.2))
    record.set_goal(1, (0.1, 0.2))
    record.set_obstacles({7: Disk(0.1, 0.02, 0.02)})
    record.set_obstacles({7: Disk(0.1, 0.05, 0.02)})
    assert record.totals.clearance == record.totals.truth.clearance == pytest.approx(-0.02)
    assert [(each.pair, each.begin, each.end) for each in record.totals.contacts] == [((-7, 1), 1.0, 1.0)]
    record.add([(0.1, 0.1)])
    (contact,) = record.totals.contacts
    assert (contact.begin, contact.pair) == (1.0, (-7, 1))
    assert record.totals.clearance == pytest.approx(-0.06)
    assert record.totals.deviation == {1: pytest.approx(0.01)}
    record.add([(0.14, 0.1)])
    assert record.totals.deviation == {1: pytest.approx(0.04)}
    record.set_fleet(
        scenario(((0.0, 0.0), (0.1, 0.0)), ((-0.1, 0.0), (0.1, 0.0))), [(0.14, 0.1), (-0.1, 0.0)], {}
    )
    assert record.totals.truth.tick == 3
    assert record.totals.deviation == {1: pytest.approx(0.04), 2: 0.0}
    assert record.segment.goals.points.tolist() == [0.1 + 0.2j, 0.1 + 0j]
    assert [truth.tick for truth in record.news()] == [0, 1, 2, 3]


def test_phi_rises_by_motion_alone():
    record = Record(scenario(((0.0, 0.0), (0.2, 0.0))), [(0.0, 0.0)])
    record.add([(0.1, 0.0)])
    near = record.totals.truth
    record.set_goal(1, (-0.2, 0.0))
    assert record.totals.truth.phi > near.phi
    record.add([(0.0, 0.0)])
    assert record.totals.increases == 0
    record.set_goal(1, (0.02, 0.0))
    record.add([(0.07, 0.0)])
    assert (record.totals.increases, record.totals.truth.phi < near.phi) == (1, True)


def test_a_contact_that_outlasts_its_world_is_one() -> None:
    """Of those that it measured itself, and of those that its plant has found."""
    places = [[(-0.1, 0.02), (-0.1, -0.01)]]
    record = Record(two(), [(-0.1, 0.1), (-0.1, -0.1)])
    for _ in range(2):
        record.add(*places, touching=[(1, 2)])
        past = msgspec.msgpack.decode(msgspec.msgpack.encode(record.past), type=PastRecord)
        record = Record(two(), *places, past=past)
    assert (record.totals.touched, record.totals.touches) == (1, [(0, (1, 2))])
    assert record.totals.collisions == 1


@pytest.mark.parametrize(("distance", "contacts"), [(0.08, 0), (0.08 - 0.5e-9, 0), (0.08 - 2e-9, 1)])
def test_an_exact_touch_is_no_contact(distance, contacts):
    """Robot 1 passes robot 2, which stands at the origin, in four ticks."""
    passing = (-0.18, distance), (0.2, distance)
    world = joined(scenario(passing, ((0.0, 0.0), (0.0, 0.1)), control=Control(k=60.0, speed=10.0)))
    for _ in range(4):
        advance(world, {1: (2.0, 0.0)})
    assert result_of(world)["collisions"] == contacts


def test_crossing_the_workspace_from_outside_to_outside_ends_one_contact_and_begins_another():
    world = joined(scenario(((0.2, 0.0), (0.0, 0.0)), control=Control(k=60.0, speed=20.0)))
    advance(world, {1: (2.0, 0.0)})
    advance(world, {1: (-13.0, 0.0)})
    first, second = result_of(world)["contacts"]
    assert first["until"] == pytest.approx(0.05 + 0.04 / 13.0, abs=1e-8)
    assert second["from"] == pytest.approx(0.05 + 0.56 / 13.0, abs=1e-8)
    assert second["until"] == pytest.approx(0.1)
    assert [first["deepest"], second["deepest"]] == pytest.approx([-0.04, -0.09])


@given(begin=st.integers(0, 9), last=st.integers(10, 30))
def test_a_trajectory_is_of_four_doubles_a_tick_and_robot(begin: int, last: int) -> None:
    ticks = range(begin, last + 1)
    expected = b"".join(
        struct.pack("<8d", tick, 3, 0.1 * tick, 0.2, tick, 5, -0.1, 0.3 * tick) for tick in ticks
    )
    places = [[(0.1 * tick, 0.2), (-0.1, 0.3 * tick)] for tick in ticks]
    assert trajectory_rows((3, 5), ticks, places) == expected
