"""Endurance: what is taken for growth, and a short run on real processes."""

from __future__ import annotations

import pytest

from tests.campaigns.campaign import Dice
from tests.campaigns.endurance import FEWEST, Sample, grown, run


def _life(rise: float = 0.0, handles: float = 0.0, samples: int = 2 * FEWEST) -> list[Sample]:
    """Samples of a process whose memory (MB) and handles grow from one to the next."""
    return [Sample(2.0 * n, 50.0 + rise * n, 9 + int(handles * n) + n % 2, 3) for n in range(samples)]


def test_what_grows_is_told() -> None:
    assert grown(_life()) == ""
    assert grown(_life(0.005)) == ""
    assert grown(_life(0.02)) == "memory rises by 1.18 MB"
    assert grown(_life(handles=0.1)).startswith("handles from 15 to ")
    assert grown(_life(1.0, samples=FEWEST - 1)) == "", "too short to tell"


@pytest.mark.process
@pytest.mark.timeout(90)
def test_a_short_run() -> None:
    outcome = run(Dice(1), robots=3, seconds=6.0, kill_every=2.0)
    assert outcome.violation == "" or "missed commands" in outcome.violation  # of a busy machine
    assert outcome.figures["kills"] > 0
    assert outcome.figures["ticks"] > 10
