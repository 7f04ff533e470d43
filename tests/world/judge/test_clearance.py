"""Gaps of disks, walls and obstacles against dense sampling; of a large fleet, those that matter."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from deploy.library.instances import random_instance
from protocol.arrays import Complexes, Reals
from protocol.geometry import ConvexPolygon, Disk, Shape
from tests.protocol.shapes import disks, points, polygons, shapes
from world.judge import clearance
from world.judge.clearance import Disks, NearestGaps, close_pairs, gaps

SAMPLES = 400
ROBOTS = 60
STEP = 0.01  # m
rooms = st.one_of(st.just(Disk(0.0, 0.0, 0.3)), polygons())
radii = st.floats(0.001, 0.1)


def inside(room: Shape, place: complex) -> float:
    """Distance from the boundary; outside of a polygon, minus that from the wall that is farthest behind."""
    if isinstance(room, Disk):
        return room.radius - abs(place)
    return min(offset - nx * place.real - ny * place.imag for nx, ny, offset in room.sides)


@settings(max_examples=40)
@given(
    rooms, st.lists(shapes, max_size=4), st.lists(st.tuples(points, points, radii), min_size=1, max_size=4)
)
def test_gaps_agree_with_dense_sampling(room, obstacles, motions):
    """No sampled instant is closer, and some sampled instant is as close as sampling can tell."""
    sizes = {number: radius for number, (_, _, radius) in enumerate(motions, 1)}
    fleet = Disks(sizes, room, dict(enumerate(obstacles, 1)))
    before = np.array([complex(*start) for start, _, _ in motions])
    after = np.array([complex(*end) for _, end, _ in motions])
    found = gaps(fleet, before[None], after[None])[0]
    assert len(found) == len(fleet)
    path = before + np.linspace(0.0, 1.0, SAMPLES)[:, None] * (after - before)
    sampled = [*(np.abs(path[:, fleet.first] - path[:, fleet.second]) - fleet.contact).min(axis=0)]
    sampled += [min(inside(room, z) for z in way) - r for way, r in zip(path.T, fleet.radii, strict=True)]
    for each in obstacles:
        sampled += [
            min(each.distance(z.real, z.imag) for z in way) - r
            for way, r in zip(path.T, fleet.radii, strict=True)
        ]
    moved = np.abs(after - before)
    travelled = np.concatenate((np.abs(fleet.relative(after - before)), np.tile(moved, 1 + len(obstacles))))
    assert np.all(found <= np.array(sampled) + 1e-12)
    assert np.all(found >= np.array(sampled) - travelled / (SAMPLES - 1) - 1e-12)


@settings(max_examples=40)
@given(st.one_of(disks, polygons()), points, points, radii)
def test_an_overlap_lasts_while_the_gap_is_negative(shape, start, end, radius):
    fleet = Disks({1: radius}, Disk(0.0, 0.0, 9.0), {7: shape})
    before, after = complex(*start), complex(*end)
    touched = [
        t
        for t in np.linspace(0.0, 1.0, SAMPLES)
        if shape.distance((before + t * (after - before)).real, (before + t * (after - before)).imag)
        < radius - 1e-6
    ]
    intervals = fleet.overlaps(1, np.array([before]), np.array([after]), 1e-9)
    if touched:
        ((first, last),) = intervals
        assert first <= touched[0]
        assert last >= touched[-1]
        assert max(touched[0] - first, last - touched[-1]) <= 1.0 / (SAMPLES - 1) + 1e-3 / max(
            abs(after - before), 1e-9
        )


@settings(max_examples=40)
@given(st.lists(shapes, min_size=1, max_size=5), st.lists(st.tuples(points, radii), min_size=1, max_size=4))
def test_beta_is_the_squared_distance_less_that_of_contact(obstacles, robots) -> None:
    fleet = Disks(
        {number: radius for number, (_, radius) in enumerate(robots, 1)},
        Disk(0.0, 0.0, 0.3),
        dict(enumerate(obstacles, 1)),
    )
    found = fleet.beta(np.array([[complex(*place) for place, _ in robots]] * 2))
    wanted = [
        radius**2 - np.hypot(*place) ** 2
        for radius, (place, _) in zip(0.3 - fleet.radii, robots, strict=True)
    ]
    for shape in sorted(obstacles, key=lambda shape: not isinstance(shape, Disk)):
        for (x, y), radius in robots:
            if isinstance(shape, Disk):
                wanted.append((x - shape.x) ** 2 + (y - shape.y) ** 2 - (shape.radius + radius) ** 2)
            else:
                wanted.append(max(shape.distance(x, y), 0.0) ** 2 - radius**2)
    assert np.allclose(found, [wanted] * 2, rtol=0.0, atol=1e-12)


# -- a large fleet


@pytest.fixture
def crowd(monkeypatch: pytest.MonkeyPatch) -> tuple[Disks, Complexes]:
    """No number of pairs is so small that all are measured; some of the obstacles overlap robots."""
    monkeypatch.setattr(clearance, "FEW", 0)
    instance, random = random_instance(ROBOTS, 1), np.random.default_rng(2)
    places = random.uniform(-0.6, 0.6, (30, 2)).tolist()
    obstacles = {
        number: Disk(x, y, 0.01) if number % 3 else ConvexPolygon([(x, y), (x + 0.03, y), (x, y + 0.02)])
        for number, (x, y) in enumerate(places, 1)
    }
    return Disks.of(instance, obstacles), np.array([complex(*spec.start) for spec in instance.robots])


def negative(fleet: Disks, found: Reals) -> list[tuple[int, tuple[int, int], float]]:
    return [(row, fleet.names(index), found[row, index]) for row, index in np.argwhere(found < 0.0).tolist()]


def assert_same(measured: tuple[Disks, Reals], fleet: Disks, before: Complexes, after: Complexes) -> None:
    some, found = measured
    wanted = gaps(fleet, before, after)
    assert found.min(axis=-1).tolist() == wanted.min(axis=-1).tolist()
    assert negative(some, found) == negative(fleet, wanted)


def test_what_matters_is_measured_while_disks_wander_and_overlap(crowd) -> None:
    fleet, places = crowd
    measure, random, fewer = NearestGaps(fleet), np.random.default_rng(0), 0
    contacts = 0
    for _ in range(50):
        steps = STEP * np.exp(2j * np.pi * random.uniform(size=(2, ROBOTS)))
        path = np.stack((places, places + steps[0], places + steps[0] + steps[1]))
        some, found = measure(path[:2], path[1:])
        assert_same((some, found), fleet, path[:2], path[1:])
        fewer += len(some.contact) < len(fleet.contact) / 3 and len(some.robot) < len(fleet.robot) / 3
        contacts += len(negative(some, found))
        places = path[-1]
    assert fewer == 50
    assert contacts > 0


def test_all_are_measured_where_a_robot_leaps_and_where_none_is_near(crowd) -> None:
    fleet, places = crowd
    measure = NearestGaps(fleet)
    measure(places[None], places[None])
    after = places.copy()
    after[0] = places[int(np.abs(places - places[0]).argmax())]
    assert_same(measure(places[None], after[None]), fleet, places[None], after[None])
    far = 100.0 * places
    assert_same(NearestGaps(fleet)(far[None], far[None]), fleet, far[None], far[None])


coordinate = st.floats(-2.0, 2.0) | st.sampled_from([0.0, 0.5, 1.0])
disk = st.tuples(st.builds(complex, coordinate, coordinate), st.floats(0.01, 0.5))


@given(st.lists(disk, max_size=12), st.floats(0.0, 1.0))
@example([(0j, 0.25), (1.5 + 0j, 0.25)], 1.0)
@example([(1j * n, 0.1) for n in range(5)], 0.8)
def test_every_close_pair_and_no_other_is_found(disks: list[tuple[complex, float]], reach: float) -> None:
    places = np.array([place for place, _ in disks], dtype=np.complex128)
    radii = np.array([radius for _, radius in disks], dtype=np.float64)
    first, second = close_pairs(places, radii, reach)
    wanted = [
        (i, j)
        for i, j in combinations(range(len(disks)), 2)
        if np.abs(places[i] - places[j]) - (radii[i] + radii[j]) <= reach
    ]
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == wanted
