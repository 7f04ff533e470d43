"""Without any one of its rules the product is not safe, and the models notice."""

from __future__ import annotations

import pytest

from tests.agents.lines.models.mutants.catalogue import MUTANTS
from tests.agents.lines.models.mutants.mutant import Mutant, hunt

pytestmark = [pytest.mark.slow, pytest.mark.campaign]


@pytest.mark.timeout(600)
@pytest.mark.parametrize("mutant", [pytest.param(each, id=each.rule) for each in MUTANTS])
def test_without_the_rule_something_goes_wrong(mutant: Mutant) -> None:
    assert hunt(mutant).violation


def test_each_rule_has_one_mutant() -> None:
    assert len({each.rule for each in MUTANTS}) == len(MUTANTS)
