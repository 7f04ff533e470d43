import math

import numpy as np
import pytest

from tests.world.driving import scenario
from world.judge.clearance import Disks
from world.judge.goals import Goals, LateralDeviation, normalised_length, tight


def at_goals(*goals, radius=0.04):
    return scenario(*[((0.0, 0.0), goal) for goal in goals], radius=radius)


def tightness(setting):
    return tight(Disks(setting), Goals(setting))


def test_tight_is_computed_in_centimetres():
    """Three robots of 4 cm with goals on a right triangle of 20, 15 and 25 cm."""
    product = (20**2 - 64) * (15**2 - 64) * (25**2 - 64)
    assert tightness(at_goals((0.0, 0.0), (0.2, 0.0), (0.0, 0.15))) == pytest.approx(
        100 / math.log10(product)
    )


@pytest.mark.parametrize(
    "goals",
    [((0.0, 0.0),), ((0.0, 0.0), (0.08, 0.0)), ((0.0, 0.0), (0.05, 0.0)), ((0.0, 0.0), (0.0805, 0.0))],
)
def test_tight_is_none_where_it_has_no_meaning(goals):
    assert tightness(at_goals(*goals)) is None


def test_normalised_length():
    setting = scenario(((0.0, 0.0), (0.3, 0.0)), ((0.1, 0.1), (0.1, 0.2)))
    assert normalised_length(Goals(setting), {1: 0.35, 2: 0.15}) == pytest.approx(0.5 / 0.4)
    assert normalised_length(Goals(at_goals((0.0, 0.0))), {1: 0.0}) is None


def test_another_goal_ends_the_straight_way_and_begins_one():
    goals = Goals(scenario(((0.0, 0.0), (0.3, 0.0)), ((0.1, 0.1), (0.1, 0.2))))
    goals.change(1, (0.1, 0.1), (0.1, 0.0))
    assert goals.straight == pytest.approx(0.1 + 0.1 + 0.1)
    assert goals.points.tolist() == [0.1 + 0.1j, 0.1 + 0.2j]
    with pytest.raises(KeyError):
        goals.change(7, (0.0, 0.0), (0.0, 0.0))


def test_the_largest_distance_from_the_straight_way_counts():
    found = LateralDeviation(Goals(scenario(((0.0, 0.0), (0.2, 0.0)), ((0.0, 0.1), (0.0, 0.1)))))
    assert found() == [0.0, 0.0]
    found.add(np.array([[0.1 + 0.03j, 0.01 + 0.1j], [0.15 - 0.02j, 0.1j]]))
    assert found() == pytest.approx([0.03, 0.01])
    found.add(np.array([[-0.03 - 0.04j, 0.1j]]))
    assert found() == pytest.approx([0.05, 0.01])
    found.add(np.array([[0.23 + 0.08j, 0.3j]]))
    assert found() == pytest.approx([np.hypot(0.03, 0.08), 0.2])


def test_a_way_in_any_direction():
    start, goal = np.array([0.1, -0.05]), np.array([-0.12, 0.07])
    found = LateralDeviation(Goals(scenario((tuple(start), tuple(goal)))))
    way = (goal - start) / np.linalg.norm(goal - start)
    for share in (0.0, 0.4, 1.0):
        x, y = start + share * (goal - start) + 0.02 * np.array([-way[1], way[0]])
        found.add(np.array([[complex(x, y)]]))
    assert found() == pytest.approx([0.02])


def test_another_goal_counts_from_where_the_robot_is():
    goals = Goals(scenario(((0.0, 0.0), (0.2, 0.0))))
    found = LateralDeviation(goals)
    found.add(np.array([[0.1 + 0.01j]]))
    goals.change(1, (0.1, 0.2), (0.1, 0.01))
    found.add(np.array([[0.1 + 0.1j]]))
    assert found() == pytest.approx([0.01])
    found.add(np.array([[0.14 + 0.1j]]))
    assert found() == pytest.approx([0.04])
