"""The proof of the safety kernel: every rule keeps the invariant and is possible, every method is covered.

`python -m tests.proof` runs these tests for all rules, or for some.
"""

from __future__ import annotations

from collections import Counter

import pytest

from tests.proof import mutants
from tests.proof.language import SOURCES, Kernel
from tests.proof.prove import CASES, RULES, is_proved_by_cvc5, obligations_of, unproved, witness
from tests.proof.walks import WEIGHTS, walk

# Methods that are no rules: steps within rules, and queries, which have no effect.
PARTS = "Held.grant Held.acknowledge Held.stand OwnEnd.begin OwnEnd.turn"
QUERIES = (
    "Ledger.tied Ledger.grants_of RobotLife.fits RobotLife.behind RobotLife.kept RobotLife.body_towards"
    " OwnEnd.obeyed Owner.obeyed Follower.obeyed Binding.end Binding.other"
)

pytestmark = pytest.mark.timeout(300)


@pytest.mark.slow
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_keeps_the_invariant(rule: str) -> None:
    assert [conjunct for conjunct, _ in unproved(CASES[rule])] == []


@pytest.mark.campaign
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_keeps_the_invariant_by_cvc5(rule: str) -> None:
    assert all(is_proved_by_cvc5(step) for step in obligations_of(CASES[rule]))


@pytest.mark.slow
@pytest.mark.parametrize("rule", CASES)
def test_a_rule_is_possible(rule: str) -> None:
    """The solver finds a state with the invariant in which the rule executes and keeps it."""
    found = witness(CASES[rule])
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
    """The solver finds a state in which the mutant breaks the invariant."""
    found = mutants.refuted(name)
    print(f"{found.rule} breaks {found.conjunct!r}" if found else "all claims are proved")
    assert (found is None) == (name in mutants.REDUNDANT)
    if found is not None:
        assert found.invalid == []
        assert found.conjunct in found.broken


def test_every_precondition_belongs_to_a_rule() -> None:
    heads = {name.split(":")[0] for name in mutants.preconditions()} - {"bind"}
    assert {head for head in heads if not any(rule.startswith(head) for rule in CASES)} == set()


def test_every_method_is_a_rule_or_a_query() -> None:
    methods = {
        f"{kind}.{name}"
        for kind, name in Kernel(SOURCES).methods
        if not kind.endswith("Geometry") and not name.startswith("_")
    }
    rules = {f"{kind}.{name}" for kind, names in RULES.items() for name in names.split()}
    assert methods == rules | set(f"{PARTS} {QUERIES}".split())


MANY = pytest.param(500, 2000, marks=pytest.mark.campaign)


@pytest.mark.parametrize(("seeds", "steps"), [pytest.param(200, 1500, marks=pytest.mark.slow), MANY])
def test_no_walk_makes_two_disks_overlap(seeds: int, steps: int) -> None:
    executed: Counter[str] = Counter()
    for seed in range(seeds):
        broken, counts = walk(seed, steps)
        assert broken == ""
        executed += counts
    assert executed.keys() == WEIGHTS.keys()
