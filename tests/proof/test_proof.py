"""The pair protocol is proved: every rule of the model keeps the whole invariant, and is possible."""

from __future__ import annotations

import pytest

from tests.proof.__main__ import by_z3, is_possible
from tests.proof.pair.invariant import PAIR

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]


@pytest.mark.parametrize("rule", PAIR.rules)
def test_a_rule_keeps_the_invariant(rule: str) -> None:
    assert [each for each in by_z3(rule) if not each.proved] == []


@pytest.mark.parametrize("rule", PAIR.rules)
def test_a_rule_is_possible(rule: str) -> None:
    assert is_possible(rule)


def test_every_text_has_its_sentence() -> None:
    texts = [*PAIR.rules.values(), *PAIR.conjuncts.values(), *PAIR.axioms.values()]
    assert [text.name for text in texts if not text.says.endswith(".")] == []
