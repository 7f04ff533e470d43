"""Whatever is lost, late or repeated, and whichever disk dies, appears or is taken away, none touch.

The campaigns `skirmish` and `aftermath` go on for longer.
"""

from __future__ import annotations

from types import ModuleType

import pytest

from tests.agents.lines.models.product import LARGE_ROOM, Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish


@pytest.mark.parametrize(
    ("model", "edits", "seeds"),
    [
        pytest.param(skirmish, (), range(20), id="no touch"),
        pytest.param(aftermath, (), range(6), id="all become ready"),
        pytest.param(skirmish, LARGE_ROOM, range(1, 76, 5), id="no touch, small regions"),
        pytest.param(aftermath, LARGE_ROOM, range(4, 34, 5), id="all become ready, small regions"),
    ],
)
@pytest.mark.slow
@pytest.mark.timeout(300)
def test_no_run_violates_anything(model: ModuleType, edits: tuple[object, ...], seeds: range) -> None:
    product = Product(edits)  # type: ignore[arg-type]
    assert [seed for seed in seeds if model.violation_of(seed, product)] == []
