"""Whatever is lost, late or repeated, whoever dies, is fenced, appears or is taken away: nobody touches."""

from __future__ import annotations

import pytest

from tests.agents.lines.models.product import LARGE_ROOM, Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish

PRODUCT = Product()


def test_nobody_touches_in_a_few_skirmishes() -> None:
    assert [seed for seed in range(60) if skirmish.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_nobody_touches_in_a_skirmish() -> None:
    assert [seed for seed in range(60, 360) if skirmish.violation_of(seed, PRODUCT)] == []


def test_when_trouble_is_over_everybody_becomes_ready() -> None:
    assert [seed for seed in range(15) if aftermath.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_when_trouble_is_over_everybody_becomes_ready_each_time() -> None:
    assert [seed for seed in range(15, 80) if aftermath.violation_of(seed, PRODUCT)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_nobody_touches_where_regions_are_small() -> None:
    product, far = Product(LARGE_ROOM), [seed for seed in range(400) if seed % 5 in (1, 4)]
    assert [seed for seed in far if skirmish.violation_of(seed, product)] == []


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_when_trouble_is_over_everybody_becomes_ready_where_regions_are_small() -> None:
    product, far = Product(LARGE_ROOM), [seed for seed in range(150) if seed % 5 in (1, 4)]
    assert [seed for seed in far if aftermath.violation_of(seed, product)] == []
