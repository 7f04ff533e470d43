"""Prove the safety kernel: `python -m tests.proof`.

Every rule, read from its source, keeps every conjunct of the invariant, and is possible: a state is found in
which it is executed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable
from multiprocessing import get_context
from typing import Any

from tests.proof import mutants
from tests.proof.prove import TEMPLATE, cases, example, is_kept_by_cvc5, not_kept, steps_of

CASES = {case.rule: case for case in cases()}


def by_z3(rule: str) -> list[str]:
    """What z3 does not prove of a rule."""
    return [f"z3 does not prove: {rule} keeps {conjunct}" for conjunct, _ in not_kept(CASES[rule])]


def by_cvc5(rule: str) -> list[str]:
    """What cvc5 does not prove."""
    kept = [is_kept_by_cvc5(step) for step in steps_of(CASES[rule])]
    return [] if all(kept) else [f"cvc5 does not prove: {rule}, in {kept.count(False)} ways of {len(kept)}"]


def is_possible(rule: str) -> list[str]:
    """Whether a state with the whole invariant was found, in which a rule was executed and kept it."""
    found = example(CASES[rule])
    possible = found is not None and not found.invalid and not found.refused and not found.broken
    return [] if possible else [f"not possible: {rule}"]


def is_needed(name: str) -> list[str]:
    """Whether a state was found in which the invariant breaks without this precondition or rule."""
    found = mutants.refuted(name)
    broken = f"{found.rule} breaks {found.conjunct!r}" if found else "nothing breaks"
    print(f"  {name}: {broken}", flush=True)
    if found is None:
        return [] if name in mutants.HARMLESS else [f"not refuted: {name}"]
    certain = not found.example.invalid and found.conjunct in found.example.broken
    return [] if certain and name not in mutants.HARMLESS else [f"not as expected: {name}"]


def main() -> int:
    """Prove what is asked for; 1 if anything is not so."""
    parser = argparse.ArgumentParser(prog="python -m tests.proof", description=__doc__)
    parser.add_argument("rules", nargs="*", help="only rules with these words in their names")
    parser.add_argument("--cvc5", action="store_true", help="ask cvc5, too")
    parser.add_argument(
        "--mutants", action="store_true", help="only refute the kernel without each of its rules"
    )
    options = parser.parse_args()

    def wanted(names: Iterable[str]) -> list[str]:
        return [name for name in names if not options.rules or any(word in name for word in options.rules)]

    if options.mutants:
        wrong = _all("refuted", is_needed, wanted(mutants.names()))
    else:
        rules = wanted(CASES)
        print(f"{len(rules)} rules, {len(TEMPLATE)} conjuncts")
        wrong = _all("proved by z3", by_z3, rules) + _all("possible", is_possible, rules)
        wrong += _all("proved by cvc5", by_cvc5, rules) if options.cvc5 else []
    print("\n".join(wrong))
    return 1 if wrong else 0


def _all(what: str, ask: Callable[[str], list[str]], names: list[str]) -> list[Any]:
    begun = time.perf_counter()
    with get_context("fork").Pool(2) as pool:
        found = pool.map(ask, names, chunksize=1)
    right = sum(not each for each in found)
    print(f"{what}: {right} of {len(names)}, {time.perf_counter() - begun:.0f} s", flush=True)
    return [each for wrong in found for each in wrong]


if __name__ == "__main__":
    sys.exit(main())
