"""Which part goes first, and where a robot goes with it."""

from __future__ import annotations

import math

import pytest

from agents.movers.floor import Grid
from agents.movers.plan import Planner
from agents.movers.traffic import Traffic, Traveller
from deploy.library.load import load
from protocol.geometry import ConvexPolygon, Disk
from protocol.scenario.model import Part, RobotSpec, Scenario, Thing, Workspace

ROOM = Workspace(points=((-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2)))


def scenario(
    *parts: tuple[tuple[float, float], tuple[float, float]], things: tuple[Thing, ...] = ()
) -> Scenario:
    """One robot of 3 cm on the left, and parts of 4 cm."""
    robot = RobotSpec(1, 0.03, (-0.25, 0.0), (-0.25, 0.0))
    return Scenario((robot,), workspace=ROOM, things=things, parts=tuple(Part(0.04, *ends) for ends in parts))


def planner(setting: Scenario) -> tuple[Planner, dict[int, tuple[float, float]]]:
    floor = {number: part.start for number, part in enumerate(setting.parts, 1)}
    return Planner(setting, setting.robots[0].radius), floor


def test_a_part_whose_place_is_taken_waits_for_the_other() -> None:
    plan, floor = planner(scenario(((-0.1, 0.0), (0.1, 0.0)), ((0.1, 0.03), (0.2, -0.1))))
    (errand,) = plan.errands((-0.25, 0.0), floor, [])
    assert errand.part == 2
    assert plan.leads_on(errand, floor, [])


def test_where_a_part_is_taken_up_there_is_room_for_the_larger_disk() -> None:
    plan, floor = planner(scenario(((0.0, 0.0), (0.2, 0.0))))
    (errand,) = plan.errands((-0.25, 0.0), floor, [])
    assert 0.07 <= math.dist(errand.fetch, (0.0, 0.0)) <= 0.08
    assert 0.08 <= math.dist(errand.deliver, (0.2, 0.0)) <= 0.09
    assert errand.cost == pytest.approx(math.dist((-0.25, 0.0), errand.fetch), rel=0.15)


def test_two_that_change_places_have_no_order_but_one_can_make_room() -> None:
    plan, floor = planner(scenario(((-0.1, 0.0), (0.1, 0.0)), ((0.1, 0.0), (-0.1, 0.0))))
    assert not plan.solvable(floor, (-0.25, 0.0), [])
    errand = plan.clearing((-0.25, 0.0), floor, [])
    assert errand is not None
    rest = {part: at for part, at in floor.items() if part != errand.part}
    spare = plan.spare(errand.part, errand.fetch, rest, [])
    assert spare is not None
    assert all(math.dist(spare, part) >= 0.08 for part in ((-0.1, 0.0), (0.1, 0.0)))
    assert plan.solvable({**floor, errand.part: spare}, (0.0, -0.15), [])


def test_no_part_goes_through_a_wall() -> None:
    wall = Thing(points=((0.0, -0.2), (0.01, -0.2), (0.01, 0.2), (0.0, 0.2)))
    plan, floor = planner(scenario(((-0.1, 0.0), (0.15, 0.0)), things=(wall,)))
    assert plan.errands((-0.25, 0.0), floor, []) == []
    assert plan.delivery(1, (0.15, 0.0), (-0.1, 0.0), {}, []) is None


def test_ways_lead_around_what_stands_and_aside_of_who_goes_first() -> None:
    grid = Grid(ROOM.shape, 0.01)
    wall = ConvexPolygon(((0.0, -0.2), (0.01, -0.2), (0.01, 0.1), (0.0, 0.1)))
    me = Traveller((-0.1, 0.0), (0.1, 0.0), 0.03, (wall,))
    x, y = Traffic(grid).aim(me, [])
    assert y > 0.1 or x < 0.0  # not straight on
    other = Traveller((-0.25, 0.0), (0.25, 0.0), 0.03, (Disk(0.0, 9.0, 0.1),))
    x, y = Traffic(grid).aim(me, [other])
    assert abs(y) > 0.0


def test_the_library_draws_parts_that_overlap_nothing() -> None:
    for seed in range(3):
        drawn = load("parts-8", [], seed)
        assert len(drawn.parts) == 8
        area = sum(each.radius**2 for each in (*drawn.robots, *drawn.parts))
        assert area / drawn.workspace.disk_radius**2 == pytest.approx(0.2, abs=1e-3)
