"""Whatever is lost, late or repeated, whoever dies, is fenced, appears or is taken away: nobody touches."""

from __future__ import annotations

import pytest

from tests.agents.lines.models import walk
from tests.agents.lines.models.product import LARGE_ROOM, Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish

PRODUCT = Product()


def test_no_walk_on_the_track_breaks_the_invariant() -> None:
    assert [seed for seed in range(300) if walk.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_no_walk_of_some_thousand_breaks_the_invariant() -> None:
    assert [seed for seed in range(1000, 3000) if walk.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.long(8)
def test_nobody_touches_in_a_skirmish() -> None:
    assert [seed for seed in range(300) if skirmish.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_nobody_touches_where_lines_rest() -> None:
    product, far = Product(LARGE_ROOM), [seed for seed in range(400) if seed % 5 in (1, 4)]
    assert [seed for seed in far if skirmish.violation_of(seed, product)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_when_trouble_is_over_everybody_becomes_ready_where_lines_rest() -> None:
    product, far = Product(LARGE_ROOM), [seed for seed in range(150) if seed % 5 in (1, 4)]
    assert [seed for seed in far if aftermath.violation_of(seed, product)] == []


def test_when_trouble_is_over_everybody_becomes_ready() -> None:
    assert [seed for seed in range(15) if aftermath.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_when_trouble_is_over_everybody_becomes_ready_each_time() -> None:
    assert [seed for seed in range(15, 80) if aftermath.violation_of(seed, PRODUCT)] == []
