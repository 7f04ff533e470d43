"""Which part goes first, and where a robot goes with it."""

import math
from dataclasses import replace
from random import Random

import pytest

from agents.parts.grid import Grid, Layout, Reach
from agents.parts.perception import Traffic, Traveller
from agents.parts.planner import Planner
from protocol.geometry import ConvexPolygon, Disk
from protocol.scenario.model import Carrying, Obstacle, Part, RobotSpec, Scenario, Workspace

ROOM = Workspace(points=((-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2)))


def scenario(
    *parts: tuple[tuple[float, float], tuple[float, float]], obstacles: tuple[Obstacle, ...] = ()
) -> Scenario:
    """One robot of 3 cm on the left, and parts of 4 cm."""
    robot = RobotSpec(1, 0.03, (-0.25, 0.0), (-0.25, 0.0))
    return Scenario(
        (robot,), workspace=ROOM, obstacles=obstacles, parts=tuple(Part(0.04, *ends) for ends in parts)
    )


def planner(setting: Scenario) -> tuple[Planner, Layout]:
    layout = Layout(
        {number: part.start for number, part in enumerate(setting.parts, 1)},
        tuple(obstacle.shape for obstacle in setting.obstacles),
    )
    return Planner(setting, setting.robots[0].radius), layout


HOME = (-0.25, 0.0)


def test_a_part_whose_place_is_taken_waits_for_the_other() -> None:
    plan, layout = planner(scenario(((-0.1, 0.0), (0.1, 0.0)), ((0.1, 0.03), (0.2, -0.1))))
    (errand,) = plan.errands(HOME, layout)
    assert errand.part == 2
    assert plan.orders.leads_on(2, layout, HOME, [])
    assert not plan.orders.leads_on(1, layout, HOME, [])


def test_where_a_part_is_taken_up_there_is_room_for_the_larger_disk() -> None:
    plan, layout = planner(scenario(((0.0, 0.0), (0.2, 0.0))))
    (errand,) = plan.errands(HOME, layout)
    deliver = plan.delivery(1, (0.2, 0.0), errand.fetch, layout.without(1))
    assert 0.07 <= math.dist(errand.fetch, (0.0, 0.0)) <= 0.08
    assert 0.08 <= math.dist(deliver, (0.2, 0.0)) <= 0.09


def test_a_part_on_a_robot_that_stands_is_taken_from_where_the_larger_disk_is_clear_of_both() -> None:
    setting = replace(scenario(((0.0, 0.0), (0.2, 0.0))), carrying=Carrying(0.02))
    plan, _ = planner(setting)
    dead = (0.05, 0.05)
    fallen = Layout({1: dead}, (Disk(*dead, 0.03),), {1: 0.04})
    (errand,) = plan.errands(HOME, fallen)
    assert 0.04 + 0.04 < math.dist(errand.fetch, dead) < 0.03 + 0.04 + 0.02
    assert plan.orders.exists(fallen, [HOME])
    near, _ = planner(replace(setting, carrying=Carrying(0.008)))  # less than the disk grows by
    assert list(near.errands(HOME, fallen)) == []
    at_goal = Layout({1: (0.2, 0.0)}, (Disk(0.2, 0.0, 0.03),), {1: 0.04})
    assert plan.orders.exists(at_goal, [HOME])  # what has its goal barred for good does not count


def test_two_that_change_places_have_no_order_but_one_can_make_room() -> None:
    there = (0.2, -0.15), (0.2, -0.15)
    plan, layout = planner(scenario(there, ((-0.1, 0.0), (0.1, 0.0)), ((0.1, 0.0), (-0.1, 0.0))))
    assert not plan.orders.exists(layout, [HOME])
    errand = plan.clearing(HOME, layout)
    assert errand.part != 1  # what is in its own place bars none
    assert plan.fetch(errand.part, HOME, layout) == errand.fetch
    aside = plan.destination(errand.part, errand.fetch, layout.without(errand.part))
    assert all(math.dist(aside, part) >= 0.08 for part in ((-0.1, 0.0), (0.1, 0.0)))
    assert plan.orders.exists(layout.moved(errand.part, aside), [(0.0, -0.15)])


def test_no_part_goes_through_a_wall() -> None:
    wall = Obstacle(points=((0.0, -0.2), (0.01, -0.2), (0.01, 0.2), (0.0, 0.2)))
    plan, layout = planner(scenario(((-0.1, 0.0), (0.15, 0.0)), obstacles=(wall,)))
    assert list(plan.errands(HOME, layout)) == []
    assert not plan.orders.exists(layout, [HOME])
    assert plan.delivery(1, (0.15, 0.0), (-0.1, 0.0), layout.without(1)) is None
    spares = list(plan._spares(1, (-0.1, 0.0), layout.without(1)))
    assert spares
    assert max(cell for cell, _ in spares)[0] < 0.0


def test_robots_on_both_sides_of_a_wall_bring_what_is_on_theirs() -> None:
    wall = Obstacle(points=((0.0, -0.2), (0.01, -0.2), (0.01, 0.2), (0.0, 0.2)))
    ends = ((-0.1, -0.1), (-0.1, 0.1)), ((0.15, -0.1), (0.15, 0.1))
    plan, layout = planner(scenario(*ends, obstacles=(wall,)))
    assert not plan.orders.exists(layout, [HOME])
    assert plan.orders.exists(layout, [HOME, (0.2, 0.0)])


def test_a_search_that_takes_too_long_finds_no_order_and_says_nothing_of_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan, layout = planner(scenario(*(((-0.1, y), (0.1, y)) for y in (-0.1, 0.0, 0.1))))
    with monkeypatch.context() as few:
        few.setattr("agents.parts.planner.MOST", 4)
        assert not plan.orders.exists(layout, [HOME])
    assert plan.orders.exists(layout.moved(1, (0.1, -0.1)), [HOME])


def test_a_robot_that_shuts_itself_in_brings_nothing_more() -> None:
    """A corridor with a niche at its end: the part that closes it goes last, though it is nearer."""
    walls = (
        Obstacle(points=((-0.1, 0.06), (0.3, 0.06), (0.3, 0.2), (-0.1, 0.2))),
        Obstacle(points=((-0.1, -0.2), (0.3, -0.2), (0.3, -0.06), (-0.1, -0.06))),
    )
    plan, layout = planner(
        scenario(((-0.2, 0.1), (-0.05, 0.0)), ((-0.2, -0.1), (0.25, 0.0)), obstacles=walls)
    )
    assert {each.part for each in plan.errands(HOME, layout)} == {1, 2}
    assert not plan.orders.leads_on(1, layout, HOME, [])
    assert plan.orders.leads_on(2, layout, HOME, [])
    assert plan.destination(1, (-0.2, 0.0), layout.without(1)) != (-0.05, 0.0)
    plan, layout = planner(
        scenario(((-0.2, 0.1), (-0.05, 0.0)), ((-0.2, -0.1), (-0.2, 0.1)), obstacles=walls)
    )
    out = plan.delivery(1, (-0.05, 0.0), (0.1, 0.0), layout.without(1))
    assert out[0] < -0.05  # where what is left to do is, though the other side is nearer


@pytest.mark.parametrize("seed", range(3))
def test_a_flood_gets_to_the_cells_that_have_a_distance(seed: int) -> None:
    random = Random(seed)
    disks = [Disk(random.uniform(-0.3, 0.3), random.uniform(-0.2, 0.2), 0.03) for _ in range(12)]
    grid = Grid(ROOM.shape, 0.01)
    reach, begin = Reach(grid), (-0.2, 0.0)
    far = grid.distance_field(grid.clear(disks, 0.03), [begin])
    reached = reach.spread(reach.clear(disks, 0.03), [begin])
    points = list(zip(map(float, grid.x.ravel()), map(float, grid.y.ravel()), strict=True))
    lengths = zip(points, grid.lengths(far, points), strict=True)
    assert reach.among(reached, points) == [point for point, way in lengths if math.isfinite(way)]


def test_a_robot_that_makes_room_is_not_shut_in_by_what_the_other_leaves() -> None:
    walls = [ConvexPolygon(((0.1, y), (0.11, y), (0.11, y + 0.15), (0.1, y + 0.15))) for y in (-0.2, 0.05)]
    me = Traveller((0.06, 0.0), (-0.25, 0.0), 0.03, tuple(walls))
    other = Traveller((-0.1, 0.0), (0.03, 0.0), 0.03, tuple(walls))
    traffic = Traffic(Grid(ROOM.shape, 0.01))
    assert traffic.aim(me, [other])[0] > 0.09  # into the room behind the gap, which is nearer
    assert traffic.aim(me, [replace(other, leaves=(Disk(0.1, 0.0, 0.04),))])[0] < 0.08
