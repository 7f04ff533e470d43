import numpy as np
import pytest

from tests.world.driving import scenario
from world.judge.deviation import LateralDeviation
from world.judge.goals import Goals


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
