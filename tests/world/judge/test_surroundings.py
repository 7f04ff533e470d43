"""Gaps to walls and things, and contacts with them, against dense sampling."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from protocol.geometry import ConvexPolygon, Disk, Shape
from protocol.scenario.model import Control, RobotSpec, Scenario, Thing, Workspace
from tests.protocol.shapes import disks, points, polygons, shapes
from world.judge.clearance import Disks
from world.judge.contacts import Contacts
from world.judge.goals import Goals
from world.judge.phi import NavigationFunction
from world.judge.record import Record
from world.judge.surroundings import Surroundings, sublevel

SAMPLES = 400
rooms = st.one_of(st.just(Disk(0.0, 0.0, 0.3)), polygons())
radii = st.floats(0.001, 0.1)


def inside(room: Shape, place: complex) -> float:
    """Distance from the boundary; outside of a polygon, minus that from the wall that is farthest behind."""
    if isinstance(room, Disk):
        return room.radius - abs(place)
    return min(offset - nx * place.real - ny * place.imag for nx, ny, offset in room.sides)


@given(
    rooms, st.lists(shapes, max_size=4), st.lists(st.tuples(points, points, radii), min_size=1, max_size=3)
)
def test_gaps_agree_with_dense_sampling(room, things, motions):
    sizes = np.array([radius for _, _, radius in motions])
    surroundings = Surroundings(room, dict(enumerate(things, 1)), sizes)
    before = np.array([complex(*start) for start, _, _ in motions])
    after = np.array([complex(*end) for _, end, _ in motions])
    found = surroundings.gaps(before[None], after[None])[0]
    assert len(found) == len(surroundings)
    path = before + np.linspace(0.0, 1.0, SAMPLES)[:, None] * (after - before)
    for robot, radius in enumerate(sizes):
        travelled = abs(after[robot] - before[robot])
        wall = min(inside(room, z) for z in path[:, robot]) - radius
        gaps = [
            wall,
            *(min(each.distance(z.real, z.imag) for z in path[:, robot]) - radius for each in things),
        ]
        mine = found[robot :: len(sizes)]
        assert np.all(mine <= np.array(gaps) + 1e-12)
        assert np.all(mine >= np.array(gaps) - travelled / (SAMPLES - 1) - 1e-12)


@given(st.one_of(disks, polygons()), points, points, radii)
def test_a_contact_lasts_while_the_gap_is_negative(shape, start, end, radius):
    surroundings = Surroundings(Disk(0.0, 0.0, 9.0), {7: shape}, np.array([radius]))
    before, after = complex(*start), complex(*end)
    touched = [
        t
        for t in np.linspace(0.0, 1.0, SAMPLES)
        if shape.distance((before + t * (after - before)).real, (before + t * (after - before)).imag)
        < radius - 1e-6
    ]
    intervals = surroundings.overlaps(1, before, after, 1e-9)
    if not touched:
        assert sum(last - first for first, last in intervals) * abs(after - before) < 0.05 or intervals
    else:
        ((first, last),) = intervals
        assert first <= touched[0]
        assert last >= touched[-1]
        assert max(touched[0] - first, last - touched[-1]) <= 1.0 / (SAMPLES - 1) + 1e-3 / max(
            abs(after - before), 1e-9
        )


def test_a_sublevel_has_both_its_ends():
    assert sublevel(lambda t: (t - 0.5) ** 2, 0.01) == (0.4, 0.6) or np.allclose(
        sublevel(lambda t: (t - 0.5) ** 2, 0.01), (0.4, 0.6), atol=1e-12
    )
    assert sublevel(lambda t: t, -0.1) is None
    assert sublevel(lambda t: -t, 5.0) == (0.0, 1.0)


BOX = ((-0.05, 0.1), (0.05, 0.1), (0.05, 0.2), (-0.05, 0.2))
ROOM = ((-1.0, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.0, 0.5))


def crossing() -> Scenario:
    """One robot that is driven through a box and a disk, and into a wall."""
    return Scenario(
        (RobotSpec(3, 0.04, (-0.5, 0.15), (0.5, -0.3)),),
        workspace=Workspace(points=ROOM),
        control=Control(k=60.0),
        things=(Thing(points=BOX), Thing(center=(0.4, 0.15), radius=0.05)),
    )


def test_contacts_name_the_thing_or_the_wall():
    setting = crossing()
    record = Record(setting, Goals(setting), [(-0.5, 0.15)])
    for place in ((0.0, 0.15), (0.5, 0.15), (0.98, 0.15), (0.98, 0.15)):
        record.add([place])
    contacts = {contact.pair: contact for contact in record.contacts.all}
    assert set(contacts) == {(-1, 3), (-2, 3), (0, 3)}
    box = contacts[(-1, 3)]
    assert math.isclose(box.begin, (0.5 - 0.09) / 0.5, abs_tol=1e-6)
    assert math.isclose(box.end, 1.0 + 0.09 / 0.5, abs_tol=1e-6)
    assert math.isclose(box.deepest, -0.09, abs_tol=1e-9)
    assert math.isclose(contacts[(0, 3)].deepest, -0.02, abs_tol=1e-9)
    assert math.isclose(record.clearance, -0.09, abs_tol=1e-9)


def test_phi_is_one_where_a_thing_or_a_wall_is_touched():
    setting = crossing()
    phi = NavigationFunction(Disks(setting), Goals(setting), setting.k)
    free, box, disk, wall, goal = phi(
        np.array([[-0.5 + 0j], [0.08 + 0.15j], [0.4 + 0.07j], [0.97 + 0j], [0.5 - 0.3j]])
    )
    assert 0.0 < free < 1.0
    assert box == disk == wall == 1.0
    assert goal == 0.0


def test_no_contact_without_overlap():
    setting = crossing()
    disks_of = Disks(setting)
    contacts = Contacts()
    still = np.array([-0.5 + 0.15j])
    contacts.add(0, disks_of, disks_of.surroundings.gaps(still, still), still, still)
    assert contacts.all == []
    assert isinstance(setting.workspace.shape, ConvexPolygon)
