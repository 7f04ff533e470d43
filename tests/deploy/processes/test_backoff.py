"""Processes that keep dying are started again ever more slowly, and the others do not notice."""

from __future__ import annotations

import time

import pytest

from deploy.processes.supervisor import STEADY, Backoff, Supervisor
from tests.deploy.processes.children import give, row, spawner, wait

PATIENCE = 20.0  # s


def test_waits_grow_to_a_cap_and_begin_anew_after_a_steady_life() -> None:
    backoff = Backoff()
    waits = [backoff.wait(1.0) for _ in range(10)]
    assert waits == [0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0, 10.0]
    assert backoff.wait(STEADY) == 0.0
    assert backoff.wait(STEADY - 0.1) == 0.25
    assert [backoff.wait(0.0) for _ in range(5000)][-1] == 10.0


@pytest.mark.process
@pytest.mark.timeout(60)
def test_one_that_keeps_dying_starves_nobody() -> None:
    with Supervisor(spawner()) as supervisor:
        supervisor.start([row("sick", give, 3, restarts=1000), row("sound", wait, reports=True)])
        supervisor.up(["sick"])
        supervisor.report("sound", PATIENCE)
        began, deaths = time.monotonic(), 0
        while time.monotonic() < began + 1.5:
            deaths += len(supervisor.poll(0.1))
        assert 3 <= deaths <= 5  # 0, 0.25 and 0.75 s after the first, then 1.75
        assert supervisor.running() in (["sound"], ["sick", "sound"])
        died = time.monotonic()
        supervisor.restart("sound")  # whoever else is started does not wait
        assert supervisor.report("sound", PATIENCE) == "waiting"
        assert time.monotonic() - died < 1.0
        supervisor.stop()
        assert supervisor.running() == []
        assert supervisor.poll(0.5) is not None
        assert supervisor.running() == [], "what was told to stop is not started again"
