"""The cores under pytest-benchmark: distributions, comparison of saved runs, and all else that it offers.

pytest tests/benchmarks/machine/bench_cores.py --benchmark-group-by=param:robots
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from tests.benchmarks.machine.cores import ROBOTS, calls

_calls = cache(calls)


@pytest.mark.parametrize("robots", ROBOTS)
@pytest.mark.parametrize("core", ["slice", "filter", "codec", "robot", "world"])
@pytest.mark.parametrize("what", ["core", "floor"])
def test_cost(benchmark: Callable[[Callable[[], object]], Any], robots: int, core: str, what: str) -> None:
    benchmark(_calls(robots)[core][what == "floor"])
