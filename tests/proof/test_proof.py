"""The safety kernel is proved: every rule keeps the whole invariant and is possible, and none is left out.

`python -m tests.proof` runs these tests of all rules, or of some.
"""

from __future__ import annotations

from collections import Counter

import pytest

from tests.proof import mutants
from tests.proof.language import SOURCES, Kernel
from tests.proof.prove import CASES, RULES, example, is_kept_by_cvc5, not_kept, steps_of
from tests.proof.walks import SHARES, walk

# Methods that are no rules: what rules do to their own objects, and what is asked and changes nothing.
PARTS = "Held.grant Held.acknowledge Held.stand OwnEnd.begin OwnEnd.turn"
QUESTIONS = (
    "Ledger.tied Ledger.told RobotLife.fits RobotLife.behind RobotLife.kept RobotLife.body_towards"
    " OwnEnd.obeyed Owner.obeyed Follower.obeyed Binding.end Binding.other"
)

pytestmark = pytest.mark.timeout(300)


@pytest.mark.slow
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_keeps_the_invariant(rule: str) -> None:
    assert [conjunct for conjunct, _ in not_kept(CASES[rule])] == []


@pytest.mark.campaign
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_keeps_the_invariant_by_cvc5(rule: str) -> None:
    assert all(is_kept_by_cvc5(step) for step in steps_of(CASES[rule]))


@pytest.mark.slow
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_is_possible(rule: str) -> None:
    """A state with the whole invariant is found, in which the rule is executed and keeps it."""
    found = example(CASES[rule])
    assert found is not None
    assert found.invalid == found.refused == found.broken == []


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.campaign if number % 16 else pytest.mark.slow)
        for number, name in enumerate(mutants.names())
    ],
)
def test_a_rule_is_needed(name: str) -> None:
    """A state is found in which the invariant breaks without this precondition or rule."""
    found = mutants.refuted(name)
    print(f"{found.rule} breaks {found.conjunct!r}" if found else "nothing breaks")
    assert (found is None) == (name in mutants.HARMLESS)
    if found is not None:
        assert found.invalid == []
        assert found.conjunct in found.broken


def test_every_precondition_belongs_to_a_rule() -> None:
    heads = {name.split(":")[0] for name in mutants.preconditions()} - {"bind"}
    assert {head for head in heads if not any(rule.startswith(head) for rule in CASES)} == set()


def test_every_method_is_a_rule_or_a_question() -> None:
    methods = {
        f"{kind}.{name}"
        for kind, name in Kernel(SOURCES).methods
        if not kind.endswith("Geometry") and not name.startswith("_")
    }
    rules = {f"{kind}.{name}" for kind, names in RULES.items() for name in names.split()}
    assert methods == rules | set(f"{PARTS} {QUESTIONS}".split())


MANY = pytest.param(500, 2000, marks=pytest.mark.campaign)


@pytest.mark.parametrize(("seeds", "steps"), [pytest.param(200, 1500, marks=pytest.mark.slow), MANY])
def test_no_walk_makes_two_disks_overlap(seeds: int, steps: int) -> None:
    taken: Counter[str] = Counter()
    for seed in range(seeds):
        broken, counts = walk(seed, steps)
        assert broken == ""
        taken += counts
    assert taken.keys() == SHARES.keys()
