"""What is recorded and read is measured. Nothing is timed here."""

from __future__ import annotations

from pathlib import Path

import pytest

from deploy.library.load import load
from tests.benchmarks.recording import journal, reading, recorder


@pytest.mark.process
@pytest.mark.timeout(60)
@pytest.mark.parametrize("variant", recorder.VARIANTS)
def test_who_records_or_watches_is_measured(variant: str) -> None:
    found = recorder.cost(load("figure-1", ["time.limit=0.5"]), variant)
    assert found.ticks_per_second > 0.0
    assert found.cpu_ms > 0.0


def test_the_ratio_is_to_the_same_round() -> None:
    plain = [recorder.Cost(400.0, 2.0), recorder.Cost(100.0, 8.0)]
    recorded = [recorder.Cost(360.0, 2.2), recorder.Cost(90.0, 8.8)]
    _, line = recorder.lines({"plain": plain, "recorded": recorded})
    assert line.split() == ["recorded", "225", "0.900", "5.50", "1.100"]


@pytest.mark.process
@pytest.mark.timeout(60)
def test_the_journal_is_measured() -> None:
    found = journal.cost(2, 0.2, rounds=1)
    assert found.plain > 0.0
    assert found.ratio == found.journalled / found.plain
    assert journal.added(2, repeat=1) < 1e6
    assert journal.replay(2).size > 20.0


@pytest.mark.process
def test_reading_is_measured(tmp_path: Path) -> None:
    count = reading.make(tmp_path / "any.mcap", 15.0, 3)
    assert count > 3 * 3 * 300
    assert reading.cost(tmp_path / "any.mcap", ("info",)).peak_mb > 10.0
    with pytest.raises(RuntimeError, match="exit status 2"):
        reading.cost(tmp_path / "none.mcap", ("info",))
