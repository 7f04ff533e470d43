"""The product without one rule of the safety protocol."""

from __future__ import annotations

from typing import NamedTuple

from tests.agents.lines.models.product import Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish
from tests.interpreted import Edit

_RUNS = 2_000  # random ones in which a mutant has to be found, at most, wherever they begin


class Mutant(NamedTuple):
    """The product without one rule.

    Attributes:
        rule: its short name.
        says: the rule.
        edits: what reads otherwise without it.
        model: whose random runs find a violation: "skirmish" or "aftermath".
        first: the random run to begin with, where it takes many to come to one that shows the mutant.
    """

    rule: str
    says: str
    edits: tuple[Edit, ...] = ()
    model: str = "skirmish"
    first: int = 0


class Found(NamedTuple):
    """A violation, and after how many runs; none if it is ""."""

    tried: int
    violation: str


def hunt(mutant: Mutant, first: int | None = None, runs: int = _RUNS) -> Found:
    """Look for what goes wrong without the rule, in random runs from `first` on, or the mutant's own."""
    product = Product(mutant.edits)
    begin = mutant.first if first is None else first
    for tried, seed in enumerate(range(begin, begin + runs), 1):
        model = skirmish if mutant.model == "skirmish" else aftermath
        violation = model.violation_of(seed, product)
        if violation:
            return Found(tried, violation)
    return Found(runs, "")
