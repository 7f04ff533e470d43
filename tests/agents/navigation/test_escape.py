"""The escape from deadlocks, switched on and off by the scenario."""

from __future__ import annotations

import pytest

from deploy.library.load import load
from deploy.run.local import LocalFleet


@pytest.mark.parametrize("filter_", ["separating-lines", "none"])
def test_on_a_saddle_only_the_escape_gets_away(filter_: str) -> None:
    settings = [f"control.filter={filter_}", "time.limit=20.0", "time.deadlock=5.0"]
    verdicts = {
        escape: LocalFleet([load("head-on", [*settings, f"control.escape={escape}"])]).execute()[0]["verdict"]
        for escape in ("true", "false")
    }
    assert verdicts == {"true": "arrived", "false": "deadlock"}
