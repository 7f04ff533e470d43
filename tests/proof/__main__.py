"""Prove the safety kernel: `python -m tests.proof`.

Every rule, executed symbolically from its source, keeps every conjunct of the invariant, and a state is found
in which it is possible.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable

import pytest

from tests.proof import mutants, test_proof
from tests.proof.prove import CASES


def main() -> int:
    """Run the tests that are asked for; 0 if all pass."""
    parser = argparse.ArgumentParser(prog="python -m tests.proof", description=__doc__)
    parser.add_argument("rules", nargs="*", help="only rules with these words in their names")
    parser.add_argument("--cvc5", action="store_true", help="ask cvc5, too")
    parser.add_argument("--mutants", action="store_true", help="refute each mutant of the kernel, only")
    options = parser.parse_args()
    asked: dict[str, Iterable[str]] = {"keeps_the_invariant": CASES, "is_possible": CASES}
    if options.cvc5:
        asked["keeps_the_invariant_by_cvc5"] = CASES
    if options.mutants:
        asked = {"is_needed": mutants.names()}
    tests = [
        f"{test_proof.__file__}::test_a_rule_{what}[{name}]"
        for what, names in asked.items()
        for name in names
        if not options.rules or any(word in name for word in options.rules)
    ]
    if not tests:
        parser.error("no rule has these words in its name")
    return int(pytest.main(["-n", "2", "-rP" if options.mutants else "-rf", *tests]))


if __name__ == "__main__":
    sys.exit(main())
