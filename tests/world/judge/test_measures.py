import math

import pytest

from tests.world.driving import scenario
from world.judge.measures import normalised_length, tight


def at_goals(*goals, radius=0.04):
    return scenario(*[((0.0, 0.0), goal) for goal in goals], radius=radius)


def test_tight_is_computed_in_centimetres():
    """Three robots of 4 cm with goals on a right triangle of 20, 15 and 25 cm."""
    product = (20**2 - 64) * (15**2 - 64) * (25**2 - 64)
    assert tight(at_goals((0.0, 0.0), (0.2, 0.0), (0.0, 0.15))) == pytest.approx(100 / math.log10(product))


@pytest.mark.parametrize(
    "goals",
    [((0.0, 0.0),), ((0.0, 0.0), (0.08, 0.0)), ((0.0, 0.0), (0.05, 0.0)), ((0.0, 0.0), (0.0805, 0.0))],
)
def test_tight_is_none_where_it_has_no_meaning(goals):
    assert tight(at_goals(*goals)) is None


def test_normalised_length():
    setting = scenario(((0.0, 0.0), (0.3, 0.0)), ((0.1, 0.1), (0.1, 0.2)))
    assert normalised_length(setting, {1: 0.35, 2: 0.15}) == pytest.approx(0.5 / 0.4)
    assert normalised_length(at_goals((0.0, 0.0)), {1: 0.0}) is None
