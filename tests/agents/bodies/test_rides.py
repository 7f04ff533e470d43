"""Bodies keep to what they must obey, whatever commands are lost; without a rule they do not."""

import pytest

from tests.agents.bodies.mutants import MUTANTS, hunt
from tests.agents.bodies.ride import KINDS, ROUNDING, Product, Ride, excess_of
from tests.interpreted import Mutant

pytestmark = pytest.mark.slow

RIDES = 2  # the campaign `bodies` goes on


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_never_leaves_what_it_must_obey(kind: str) -> None:
    product = Product()
    for seed in range(RIDES):
        assert excess_of(seed, kind, product) <= ROUNDING, f"seed {seed}"


@pytest.mark.parametrize("kind", KINDS)
def test_and_does_not_keep_to_it_by_standing(kind: str) -> None:
    """Of the way that it would go if nothing were in the way, some share; standing would give none."""
    product, way, most = Product(), 0.0, 0.0
    for seed in range(10):  # of fewer, some hardly have room to go anywhere
        ride = Ride(seed, kind, product, period=0.1)
        for _ in range(60):
            x, y = ride.x, ride.y
            ride.tick()
            way += abs(complex(ride.x - x, ride.y - y))
            most += ride.speed * ride.period
    assert way > 0.03 * most


@pytest.mark.campaign
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.rule)
def test_without_a_rule_it_does(mutant: Mutant) -> None:
    assert hunt(mutant).excess > ROUNDING
