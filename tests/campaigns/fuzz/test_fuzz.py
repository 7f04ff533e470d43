"""The fuzzer: a few thousand inputs for every test run, and what it does with a find."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.campaigns.campaign import Dice
from tests.campaigns.driver import attempt
from tests.campaigns.fuzz.campaign import FUZZ, TARGETS, drawn, target_of


@pytest.mark.slow
def test_nothing_but_declared_errors() -> None:
    outcomes = [attempt(FUZZ, Dice(seed)) for seed in range(8000)]
    assert [each.shows for each in outcomes if each.violation] == []
    said = Counter(each.said for each in outcomes)
    assert all(said[f"{name}, accepted"] for name in TARGETS)
    assert all(
        said[f"{name}, refused"] for name in TARGETS.keys() - {"log"}
    )  # that shows what it cannot read


@pytest.mark.slow
def test_an_input_is_drawn_from_its_seed_alone() -> None:
    assert repr(drawn(41)) == repr(drawn(41))
    assert len({repr(drawn(n)) for n in range(200)}) > 150
    assert {target_of(n) for n in range(sum(each.share for each in TARGETS.values()))} == set(TARGETS)
