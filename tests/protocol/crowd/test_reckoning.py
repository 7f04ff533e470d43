"""What is left out of Ticks is what their robots know, whatever was lost before, and nothing else."""

from __future__ import annotations

from typing import NamedTuple

from hypothesis import given
from hypothesis import strategies as st

from agents.localisation.reckoning import Reckoning
from protocol.messages import Sense, Vector
from world.coordinator.crowd.omission import Omission

STEP = 0.1  # s
numbers = st.floats(-0.1, 0.1)


class Happens(NamedTuple):
    """In one tick."""

    velocity: Vector
    heard: bool  # the Tick, by the robot
    taken: bool  # its Command, by the world
    slips: bool
    noisy: bool
    begins_anew: bool  # the robot, with another life


ticks = st.builds(
    Happens,
    st.tuples(numbers, numbers),
    *[st.sampled_from((True, True, True, False))] * 2,
    *[st.booleans()] * 3,
)


@given(st.lists(ticks, max_size=30))
def test_a_robot_knows_all_that_is_sensed_of_it(run: list[Happens]) -> None:
    omission, reckoning, life = Omission(STEP), Reckoning(STEP), 1
    (x, y), (dx, dy) = (0.3, -0.2), (0.0, 0.0)
    commanded: dict[int, Vector] = {}
    for tick, each in enumerate(run):
        if each.begins_anew:
            reckoning, life = Reckoning(STEP), life + 1
        sensed = Sense((x, y), tick, 0.01 if each.noisy else 0, (dx, dy), 0)
        told, omitted = omission.sift(tick, {1: sensed}, commanded, {1: life})
        assert told.keys() | omitted == {1}
        if each.heard:
            assert reckoning.sense(tick, told.get(1), went_as_commanded=1 in omitted) == sensed
            reckoning.commanded(tick, each.velocity)
        commanded = {1: each.velocity} if each.heard and each.taken else {}
        vx, vy = commanded.get(1, (0.0, 0.0))
        dx, dy = vx * STEP + 0.001 * each.slips, vy * STEP
        x, y = x + dx, y + dy


def test_who_goes_as_commanded_is_told_once() -> None:
    omission, place = Omission(STEP), (0.3, -0.2)
    told = []
    for tick in range(4):
        moved = (0.05 * STEP, 0.0) if tick else (0.0, 0.0)
        place = place[0] + moved[0], place[1] + moved[1]
        told.append(omission.sift(tick, {1: Sense(place, tick, 0, moved, 0)}, {1: (0.05, 0.0)}, {1: 1}))
    assert [1 in each for each, _ in told] == [True, False, False, False]


def test_who_is_told_nothing_or_knows_nothing_is_blind() -> None:
    reckoning = Reckoning(STEP)
    assert reckoning.sense(0, None, went_as_commanded=True) is None
    reckoning.sense(1, Sense((0.0, 0.0), 1, 0, (0.0, 0.0)), went_as_commanded=False)
    assert reckoning.sense(2, None, went_as_commanded=True) is None  # it has not commanded in tick 1
    reckoning.sense(3, Sense((0.0, 0.0), 3, 0, (0.0, 0.0)), went_as_commanded=False)
    reckoning.commanded(3, (0.1, 0.0))
    assert reckoning.sense(4, None, went_as_commanded=False) is None  # nobody says that it was carried out
