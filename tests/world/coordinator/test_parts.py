"""Parts: taken up by a robot as a larger disk, put down once all keep clear, taken from static robots."""

from dataclasses import replace

import pytest

from protocol.geometry import Disk
from protocol.messages import Command, Handling, PartPlace
from protocol.scenario.model import Obstacle, Operation, Part, Time, Workspace
from tests.world.driving import joined, obeying, scenario
from world.report import result_of
from world.world import WorldCore

SMALL, LARGE = 0.04, 0.05
AT, GOAL = (0.095, 0.0), (-0.105, 0.0)  # of the part; each within reach of robot 1 at the origin
TAKE = Handling(1, LARGE)
PUT = Handling(1, LARGE, GOAL)


def world(*others: Part) -> WorldCore:
    """Robot 1 beside a part, robot 2 and other parts elsewhere, and a first tick that is over."""
    setting = replace(
        scenario(((0.0, 0.0), (0.0, 0.3)), ((0.0, -0.3), (0.0, -0.4)), radius=SMALL),
        workspace=Workspace(0.6),
        parts=(Part(LARGE, AT, GOAL), *others),
        time=Time(limit=60.0, fence=0.2),
    )
    found = joined(setting)
    tick(found)
    return found


def tick(
    found: WorldCore,
    asks: dict[int, Handling] | None = None,
    *,
    kept: bool = True,
    silent: tuple[int, ...] = (),
) -> None:
    """A tick in which robots ask for something, and keep clear of what is to appear or not."""
    told = found.open_tick()
    for robot in found.exchange.active:
        if robot not in silent:
            assert found.accept(obeying(told[robot], clear=kept, handles=(asks or {}).get(robot)))
    found.close_tick()


def radius(found: WorldCore, robot: int) -> float:
    return found.lives.roster.members[robot].radius


def where(found: WorldCore) -> PartPlace:
    return found.lives.roster.message.parts[0]


def test_a_part_that_is_taken_up_is_gone_and_its_carrier_larger() -> None:
    found = world()
    assert (where(found), radius(found, 1)) == (PartPlace(1, 1), SMALL)
    tick(found, {1: TAKE})
    assert (where(found), radius(found, 1)) == (PartPlace(1, carrier=1), LARGE)
    assert not found.lives.obstacles.standing
    assert result_of(found)["collisions"] == 0


@pytest.mark.parametrize(
    ("robot", "handling"),
    [(1, Handling(1, SMALL)), (2, TAKE), (1, Handling(2, LARGE)), (1, PUT)],
    ids=["not clear of what the larger disk needs", "out of reach", "no such part", "nothing to put down"],
)
def test_what_cannot_be_handled_stays(robot: int, handling: Handling) -> None:
    found = world()
    before = found.lives.roster.message
    tick(found, {robot: handling})
    assert found.lives.roster.message == before


def test_no_robot_handles_parts_in_an_emergency_stop() -> None:
    found = world()
    found.operate(Operation(halt=True))
    tick(found, {1: TAKE})
    assert where(found).carrier == 0


def test_a_part_is_put_down_once_all_keep_clear_and_its_carrier_stays_large_until_then() -> None:
    found = world()
    tick(found, {1: TAKE})
    tick(found, {1: PUT}, kept=False)
    assert where(found) == PartPlace(1, 2, 1)
    tick(found, {1: PUT}, kept=False)
    assert (where(found).carrier, radius(found, 1)) == (1, LARGE)
    tick(found, {1: PUT})
    tick(found, {1: PUT})
    assert (where(found), radius(found, 1)) == (PartPlace(1, 2), SMALL)
    assert not found.parts.pending


def test_a_robot_that_no_longer_asks_has_put_nothing_down() -> None:
    found = world()
    tick(found, {1: TAKE})
    tick(found, {1: PUT}, kept=False)
    tick(found, silent=(1,), kept=False)
    assert where(found) == PartPlace(1, 2, 1), "it may ask still"
    tick(found, kept=False)
    assert where(found) == PartPlace(1, carrier=1)
    assert not found.lives.obstacles.appearing


@pytest.mark.parametrize(
    "handling",
    [
        *(Handling(1, LARGE, place) for place in ((-0.2, 0.0), (-0.08, 0.0), (0.0, -0.105))),
        *(Handling(2, LARGE, GOAL), Handling(2, LARGE)),
    ],
    ids=["out of reach", "in its own disk", "outside", "what it has not", "a second one"],
)
def test_what_is_carried_stays_on_its_carrier(handling: Handling) -> None:
    found = world(Part(LARGE, (0.0, 0.095), (0.0, 0.5)))
    tick(found, {1: TAKE})
    if handling.place == (0.0, -0.105):
        found.simulation.plant.positions[0] = (0.0, -0.5)
        handling = Handling(1, LARGE, (0.0, -0.605))
    before = found.lives.roster.message
    tick(found, {1: handling}, kept=False)
    assert found.lives.roster.message == before
    assert found.parts.carried_by(1) == 1


def test_no_part_is_put_down_where_an_obstacle_is_to_appear() -> None:
    found = world()
    tick(found, {1: TAKE})
    assert found.operate(Operation(place=Obstacle(center=(-0.15, 0.0), radius=0.02))).accepted
    tick(found, {1: PUT}, kept=False)
    assert where(found) == PartPlace(1, carrier=1)


def test_no_robot_takes_a_part_from_one_that_lives() -> None:
    found = world()
    tick(found, {1: TAKE})
    found.simulation.plant.positions[1] = (0.0, -0.095)  # of robot 2
    tick(found, {2: TAKE})
    assert where(found) == PartPlace(1, carrier=1)


@pytest.mark.parametrize("last", [TAKE, PUT], ids=["carries", "puts down"])
def test_a_robot_that_dies_stands_with_what_it_carries_until_another_takes_it(last: Handling) -> None:
    found = world()
    tick(found, {1: TAKE})
    tick(found, {1: last}, kept=False)
    for _ in range(5):
        tick(found, {2: TAKE}, silent=(1,), kept=False)
    assert found.lives.roster.status(1) == "standing"
    assert where(found) == PartPlace(1, carrier=1)
    assert not found.lives.obstacles.appearing
    found.simulation.plant.positions[1] = (0.0, -0.095)  # of robot 2
    tick(found, {2: TAKE}, silent=(1,), kept=False)
    assert (where(found).carrier, radius(found, 1), radius(found, 2)) == (2, SMALL, LARGE)
    assert found.lives.keeper.excludes(1, Disk(0.0, 0.005, SMALL), SMALL), (
        "it holds no more than its own disk"
    )


def test_parts_and_carriers_are_not_taken_away_by_operators() -> None:
    found = world()
    assert found.operate(Operation(place=Obstacle(center=(0.5, 0.0), radius=0.02))).accepted
    tick(found)
    tick(found)
    assert found.operate(Operation(take=2)).accepted
    assert "is part 1" in found.operate(Operation(take=1)).text
    tick(found, {1: TAKE})
    assert found.operate(Operation(remove=1)).text == "robot 1 carries part 1"


def test_a_robot_that_leaves_with_this_tick_takes_nothing_up() -> None:
    found = world()
    told = found.open_tick()
    assert found.operate(Operation(remove=1)).text == ""
    assert found.accept(Command(1, told[1].incarnation, found.tick, (0.0, 0.0), handles=TAKE))
    found.close_tick()
    assert found.lives.roster.status(1) == "gone"
    assert where(found) == PartPlace(1, 1)
