"""Whatever is lost, late or repeated, and whichever disk dies, appears or is taken away, none touch; without
any one rule some do. The campaigns `skirmish` and `aftermath` go on for longer.
"""

from types import ModuleType

import pytest

from tests.agents.lines.models.mutants import MUTANTS, hunt
from tests.agents.lines.models.product import LARGE_ROOM, Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish
from tests.interpreted import Mutant


@pytest.mark.parametrize(
    ("model", "edits", "seeds"),
    [
        pytest.param(skirmish, (), range(10), id="no touch"),
        pytest.param(aftermath, (), range(4), id="all become ready"),
        pytest.param(skirmish, LARGE_ROOM, range(1, 41, 5), id="no touch, small regions"),
        pytest.param(aftermath, LARGE_ROOM, range(4, 24, 5), id="all become ready, small regions"),
    ],
)
@pytest.mark.slow
@pytest.mark.timeout(300)
def test_no_run_violates_anything(model: ModuleType, edits: tuple[object, ...], seeds: range) -> None:
    product = Product(edits)  # type: ignore[arg-type]
    assert [seed for seed in seeds if model.violation_of(seed, product)] == []


@pytest.mark.campaign
@pytest.mark.timeout(600)
@pytest.mark.parametrize("mutant", [pytest.param(each, id=each.rule) for each in MUTANTS])
def test_without_the_rule_something_goes_wrong(mutant: Mutant) -> None:
    assert hunt(mutant).violation
