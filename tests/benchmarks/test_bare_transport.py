"""The floor benchmark itself: it ticks, on raw zenoh and on the bus."""

from __future__ import annotations

from typing import Literal

import pytest

from tests.benchmarks.bare_transport import rate


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("bus", ["raw", "bus"])
def test_bare_ticks(bus: Literal["raw", "bus"]) -> None:
    measured = rate(3, 0.2, bus)
    assert measured.ticks_per_second > 0.0
    assert measured.cpu_ms >= 0.0
