"""Prove the pair protocol: `python -m tests.proof`.

Every rule of the model keeps every conjunct of the invariant, and is possible; and the product's source does
what the rules do.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable
from multiprocessing import get_context
from typing import Any

from tests.proof.engine.find import Universe, find
from tests.proof.engine.prove import Obligation, contradicts_for_cvc5, prove
from tests.proof.pair.invariant import PAIR
from tests.proof.pair.source import cases, deviations

SMALL = Universe(PAIR, 3, 4)


def by_z3(rule: str) -> list[Obligation]:
    """What z3 says of a rule."""
    return prove(PAIR, PAIR.rules[rule])


def by_cvc5(rule: str) -> list[Obligation]:
    """What cvc5 says of a rule."""
    return prove(PAIR, PAIR.rules[rule], contradicts_for_cvc5)


def is_possible(rule: str) -> bool:
    """Whether a state was found with the whole invariant, in which a rule was executed and kept it."""
    example = find(PAIR, PAIR.rules[rule], SMALL)
    return example is not None and not example.broken


def main() -> int:
    """Prove what is asked for; 1 if anything is not so."""
    parser = argparse.ArgumentParser(prog="python -m tests.proof", description=__doc__)
    parser.add_argument("rules", nargs="*", help="only rules with these words in their names")
    parser.add_argument("--cvc5", action="store_true", help="ask cvc5, too")
    options = parser.parse_args()
    rules = [name for name in PAIR.rules if not options.rules or any(word in name for word in options.rules)]
    print(f"{len(PAIR.rules)} rules, {len(PAIR.conjuncts)} conjuncts")
    wrong = _proved("z3", by_z3, rules)
    if options.cvc5:
        wrong += _proved("cvc5", by_cvc5, rules)
    begun = time.perf_counter()
    impossible = [
        rule for rule, possible in zip(rules, _all(is_possible, rules), strict=True) if not possible
    ]
    print(
        f"possible: {len(rules) - len(impossible)} of {len(rules)} rules, {time.perf_counter() - begun:.0f} s"
    )
    wrong += [f"not possible: {rule}" for rule in impossible]
    if not options.rules:
        wrong += _read()
    print("\n".join(wrong))
    return 1 if wrong else 0


def _all(ask: Callable[[str], Any], rules: Iterable[str]) -> Iterable[Any]:
    with get_context("fork").Pool(2) as pool:
        yield from pool.imap(ask, rules)


def _read() -> list[str]:
    """Read the source; what it does that no rule does."""
    begun = time.perf_counter()
    found = [each for case in cases() for each in deviations(case)]
    wrong = [each for each in found if each]
    seconds = time.perf_counter() - begun
    print(f"source: {len(found) - len(wrong)} of {len(found)} ways as ruled, {seconds:.0f} s")
    return wrong


def _proved(solver: str, ask: Callable[[str], list[Obligation]], rules: list[str]) -> list[str]:
    """Ask a solver of each rule; what it does not prove."""
    begun = time.perf_counter()
    found = [each for obligations in _all(ask, rules) for each in obligations]
    seconds, slowest = sum(each.seconds for each in found), max(found, key=lambda each: each.seconds)
    proved = sum(each.proved for each in found)
    print(
        f"{solver}: {proved} of {len(found)} obligations proved, {time.perf_counter() - begun:.0f} s"
        f" ({seconds:.0f} s of a core, at most {slowest.seconds:.2f} s: {slowest.rule}, {slowest.conjunct})"
    )
    return [
        f"{solver} does not prove: {each.rule} keeps {each.conjunct}" for each in found if not each.proved
    ]


if __name__ == "__main__":
    sys.exit(main())
