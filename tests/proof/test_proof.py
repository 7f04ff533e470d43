"""The pair protocol is proved: every rule of the model keeps the whole invariant, and is possible."""

from __future__ import annotations

import pytest

from tests.interpreted import Edit
from tests.proof.__main__ import by_z3, is_possible
from tests.proof.pair.invariant import PAIR
from tests.proof.pair.mutants import MUTANTS
from tests.proof.pair.source import Case, cases, deviations

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]


@pytest.mark.parametrize("rule", PAIR.rules)
def test_a_rule_keeps_the_invariant(rule: str) -> None:
    assert [each for each in by_z3(rule) if not each.proved] == []


@pytest.mark.parametrize("rule", PAIR.rules)
def test_a_rule_is_possible(rule: str) -> None:
    assert is_possible(rule)


@pytest.mark.parametrize("case", [pytest.param(each, id=each.name) for each in cases()])
def test_the_source_does_what_rules_do(case: Case) -> None:
    assert [each for each in deviations(case) if each] == []


@pytest.mark.campaign
@pytest.mark.parametrize("mutant", [pytest.param(each, id=each[0]) for each in MUTANTS])
def test_the_source_without_a_rule_is_told_apart(mutant: tuple[str, *tuple[Edit, ...]]) -> None:
    assert any(each for case in cases(mutant[1:]) for each in deviations(case))


def test_every_text_has_its_sentence() -> None:
    texts = [*PAIR.rules.values(), *PAIR.conjuncts.values(), *PAIR.axioms.values()]
    assert [text.name for text in texts if not text.says.endswith(".")] == []
