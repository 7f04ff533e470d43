"""The safety kernel is proved: every rule keeps the whole invariant and is possible."""

from __future__ import annotations

from collections import Counter
from random import Random

import pytest

from tests.proof import mutants
from tests.proof.__main__ import CASES, by_z3, is_needed, is_possible
from tests.proof.walks import Walk, walk

pytestmark = pytest.mark.timeout(300)


@pytest.mark.slow
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_keeps_the_invariant(rule: str) -> None:
    assert by_z3(rule) == []


@pytest.mark.slow
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_is_possible(rule: str) -> None:
    assert is_possible(rule) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", mutants.names()[::16])
def test_a_rule_is_needed(name: str) -> None:
    assert is_needed(name) == []


@pytest.mark.campaign
def test_every_rule_is_needed() -> None:
    assert [each for name in mutants.names() for each in is_needed(name)] == []


def test_every_precondition_belongs_to_a_rule() -> None:
    heads = {name.split(":")[0] for name in mutants.preconditions()} - {"bind"}
    assert {head for head in heads if not any(rule.startswith(head) for rule in CASES)} == set()


@pytest.mark.slow
def test_no_walk_makes_two_disks_overlap() -> None:
    taken: Counter[str] = Counter()
    for seed in (*range(40), 78, 196):  # in the last two a part is taken up
        broken, counts = walk(seed, 1500)
        assert broken == ""
        taken += counts
    assert taken.keys() == Walk(Random(0)).rules.keys()
