"""Which robots are bound, which region each is granted, and what each is told of it."""

from dataclasses import replace

import pytest

from protocol.geometry import Disk
from protocol.messages import Command, FirstLine, Grants, Vector
from protocol.scenario.model import Obstacle, Scenario
from protocol.scenario.network import Network
from tests.world.driving import scenario
from world.coordinator.keeper import Keeper

PLACES: dict[int, Vector] = {1: (-0.1, 0.0), 2: (0.1, 0.0), 3: (0.0, 0.15)}
OBSTACLE = Disk(0.0, -0.1, 0.02)


def fleet(reach: float | None = None) -> Scenario:
    found = scenario(*((place, place) for place in PLACES.values()))
    return found if reach is None else replace(found, network=Network("near", reach))


def founded(setting: Scenario, *, live: tuple[int, ...] = (1, 2, 3)) -> Keeper:
    keeper = Keeper(setting)
    keeper.found({robot: Disk(*place, 0.04) for robot, place in PLACES.items()}, {1: OBSTACLE})
    for robot in live:
        keeper.rejoin(robot)
    return keeper


def settled(setting: Scenario, *, live: tuple[int, ...] = (1, 2, 3)) -> Keeper:
    """After the first tick, in which all that live obey what they are told."""
    keeper = founded(setting, live=live)
    keeper.advance(PLACES)
    obey_all(keeper)
    return keeper


def obey(keeper: Keeper, robot: int, told: Grants, *firsts: FirstLine) -> None:
    """With a first line wherever one is asked for."""
    asked = (each.number for each in told.bindings if each.first is None)
    firsts += tuple(FirstLine(number, 1.0, 0.0, 0.5) for number in asked)
    said = Command(robot, 1, 0, (0.0, 0.0), version=told.version, region=told.number, firsts=firsts)
    assert not keeper.refuses(said)
    keeper.acknowledge(said)


def obey_all(keeper: Keeper) -> None:
    for robot in PLACES:
        told = keeper.news(robot)
        if told is not None:
            obey(keeper, robot, told)


def test_in_a_small_fleet_all_are_bound_as_the_run_begins_and_may_be_anywhere() -> None:
    keeper = founded(fleet())
    keeper.advance({})
    told = keeper.news(1)
    assert told.region is None
    assert sorted(each.peer for each in told.bindings) == [-1, 2, 3]
    assert all(each.first is not None for each in told.bindings)
    first = next(each.first for each in told.bindings if each.peer == 2)
    assert first == (pytest.approx(1.0), pytest.approx(0.0), pytest.approx(0.0))
    obey(keeper, 1, told)
    keeper.advance({})
    assert keeper.news(1) is None


def test_a_life_that_is_over_stands_for_the_others_until_the_next_has_a_line_with_each() -> None:
    keeper = settled(fleet())
    keeper.fence(2, Disk(0.05, 0.0, 0.04))
    assert keeper.news(2) is None
    (peer,) = (each for each in keeper.news(1).bindings if each.peer == 2)
    assert (peer.static, peer.points) == (True, ((0.05, 0.0),))
    obey_all(keeper)
    keeper.rejoin(2)
    keeper.advance({})
    assert keeper.news(2).number < keeper.news(2).life  # no region of its own yet
    for robot in (1, 3):
        told = keeper.news(robot)
        (asked,) = (each for each in told.bindings if each.first is None)
        assert (asked.peer, asked.static) == (2, False)
        obey(keeper, robot, told)
        firsts = {each.number: each.first for each in keeper.news(robot).bindings}
        assert None not in firsts.values()
        assert firsts[asked.number] == (1.0, 0.0, 0.5)
    obey_all(keeper)
    keeper.advance({})
    told = keeper.news(2)
    assert told.number > told.life
    assert sorted(each.peer for each in told.bindings) == [-1, 1, 3]
    assert not any(each.static for each in keeper.news(1).bindings if each.peer == 2)


def test_a_disk_appears_once_every_life_keeps_clear_of_its_place() -> None:
    keeper = settled(fleet(), live=(1, 2))
    keeper.announce(-2, Disk(0.0, 0.0, 0.01))
    keeper.advance({})
    for robot in (1, 2):
        obey(keeper, robot, keeper.news(robot))
        assert keeper.appear(-2) == (robot == 2)
    keeper.rejoin(3)
    keeper.advance({})
    assert -2 in {each.peer for each in keeper.news(3).bindings}


def test_a_disk_does_not_appear_where_one_stands() -> None:
    keeper = settled(fleet(), live=(1,))
    keeper.announce(-2, Disk(0.1, 0.02, 0.01))  # on robot 2, which has no process
    for _ in range(3):
        assert not keeper.appear(-2)
        obey_all(keeper)
    keeper.rejoin(2)
    keeper.advance({})
    obey(keeper, 1, keeper.news(1))
    keeper.advance({})
    assert keeper._ledger.disks[2].held.granted > keeper._ledger.disks[2].life, "it may leave"


def test_a_disk_appears_beside_a_wall_and_an_obstacle_in_another() -> None:
    keeper = Keeper(fleet())
    keeper.found({}, {1: Obstacle(points=((-1.0, 0.0), (1.0, 0.0), (1.0, 0.02))).shape})
    for name, disk in ((4, Disk(0.0, 0.1, 0.04)), (-2, Disk(0.0, 0.0, 0.04))):
        keeper.announce(name, disk)
        assert keeper.appear(name)


def test_a_robot_that_touches_an_obstacle_is_asked_for_a_line() -> None:
    keeper = Keeper(fleet())
    keeper.found({1: Disk(0.0, 0.0, 0.08)}, {1: OBSTACLE})
    keeper.rejoin(1)
    keeper.advance({})
    assert [each.first for each in keeper.news(1).bindings] == [None]


def test_in_a_large_fleet_only_robots_whose_regions_meet_are_bound() -> None:
    keeper = founded(fleet(0.2))  # slack 0.1
    keeper.advance(PLACES)
    assert sorted(each.peer for each in keeper.news(1).bindings) == [-1, 2, 3]
    keeper = founded(fleet(0.1))  # a gap of 0.12 between 1 and 2
    keeper.advance(PLACES)
    told = keeper.news(1)
    assert told.region == pytest.approx((-0.1, 0.0, 0.09))
    assert 2 not in {each.peer for each in told.bindings}
    keeper.advance(PLACES | {1: (-0.2, 0.0)})
    assert keeper.news(1).region == told.region, "until it obeys that"


def test_on_a_large_map_a_robot_is_bound_to_the_obstacles_near_it_only() -> None:
    many = replace(
        fleet(), obstacles=tuple(Obstacle(center=(0.001 * n, 0.2), radius=0.001) for n in range(201))
    )
    keeper = Keeper(many)
    keeper.found({1: Disk(*PLACES[1], 0.04)}, {n: each.shape for n, each in enumerate(many.obstacles, 1)})
    keeper.rejoin(1)
    keeper.advance(PLACES)
    told = keeper.news(1)
    assert told.region is not None
    assert len(told.bindings) < 201
    assert not replace(many, obstacles=many.obstacles[:200]).hears_near


def test_robots_that_part_are_bound_no_more() -> None:
    keeper = founded(fleet(0.2))
    for step in range(40):
        keeper.advance(PLACES | {1: (-0.1 - 0.01 * step, 0.0)})
        obey_all(keeper)
        bound = [peer in keeper.bound(robot) for robot, peer in ((1, 2), (2, 1))]
        assert step > 0 or all(bound)
    assert not any(bound)


def test_what_was_never_granted_cannot_be_obeyed() -> None:
    keeper = founded(fleet())
    keeper.advance({})
    told = keeper.news(1)
    lies = ((told.version + 1, told.number), (told.version, told.number + 1), (0, told.number))
    for version, region in lies:
        assert keeper.refuses(Command(1, 1, 0, (0.0, 0.0), version=version, region=region))


def test_a_number_from_before_the_life_is_no_region_that_it_obeys() -> None:
    keeper = founded(fleet(0.05), live=(1,))
    keeper.advance({})
    told, held = keeper.news(1), keeper._ledger.disks[1].held
    before = held.regions
    keeper.acknowledge(Command(1, 1, 0, (0.0, 0.0), version=told.version, region=told.life))
    assert held.regions == before, "its place is held until it obeys another region"


def test_a_first_line_that_was_not_asked_for_changes_nothing() -> None:
    keeper = settled(fleet())
    keeper.fence(2, Disk(0.05, 0.0, 0.04))
    keeper.rejoin(2)
    keeper.advance({})
    told = keeper.news(1)
    (asked,) = (each.number for each in told.bindings if each.first is None)  # not 2
    version = keeper.version
    firsts = (FirstLine(number, 1.0, 0.0, 0.0) for number in (1, asked, 10**6))
    obey(keeper, 2, keeper.news(2), *firsts)
    keeper.acknowledge(Command(1, 1, 0, (0.0, 0.0), firsts=(FirstLine(10**6, 1.0, 0.0, 0.0),)))
    assert keeper.version == version
    for _ in range(2):  # repeated, until it is told
        obey(keeper, 1, told)
        assert keeper.version == version + 1


def test_a_robot_waits_for_one_that_holds_regions_on_both_sides_of_it() -> None:
    keeper = settled(fleet(0.1), live=(1, 2))
    keeper.advance(PLACES)
    assert keeper.news(1) is keeper.news(2) is None
    for robot, place in ((1, (0.3, 0.0)), (2, (0.14, 0.0))):
        keeper.advance(PLACES | {1: (0.3, 0.0), robot: place})
    assert keeper.news(2) is None
    obey_all(keeper)
    keeper.advance(PLACES | {1: (0.3, 0.0), 2: (0.14, 0.0)})
    assert keeper.news(2).region == pytest.approx((0.14, 0.0, 0.09))
    assert 2 in {each.peer for each in keeper.news(1).bindings}


def test_a_static_disk_is_restricted_to_a_smaller_place_inside_its_own() -> None:
    keeper = settled(fleet(), live=(1,))
    assert [keeper.excludes(2, Disk(x, 0.0, 0.04), 0.035) for x in (0.109, 0.111)] == [False, True]
    version = keeper.version
    for place in (Disk(0.1, 0.0, 0.04), Disk(0.12, 0.0, 0.03)):
        keeper.settle(2, place)
        assert keeper.version == version
    keeper.settle(2, Disk(0.11, 0.0, 0.03))
    (peer,) = (each for each in keeper.news(1).bindings if each.peer == 2)
    assert (peer.points, peer.radius) == (((0.11, 0.0),), 0.03)
