"""Real time waits for none once all are set up; a tick in slow motion takes as long as is asked."""

import pytest

from deploy.run.local import LocalFleet
from tests.skipped_waits import skipped_waits
from tests.world.driving import STEP, Stopwatch, two
from world.shell.failure_detector import GATHERING
from world.shell.pacing import BEAT, FIRST, Pacing

TICK = 0.1


def test_the_first_tick_of_real_time_waits_but_not_for_ever() -> None:
    now = 0.0
    pacing = Pacing(False, 0.0, lambda: now)
    pacing.begin(0, TICK)
    now = pacing.deadline
    assert now == TICK
    while pacing.prolongs(0, now):
        assert now < pacing.deadline <= now + TICK
        now = pacing.deadline
    assert now >= FIRST
    pacing.begin(1, TICK)
    assert pacing.since == now  # nothing is caught up with
    now = pacing.deadline
    assert not pacing.prolongs(1, now)


@pytest.mark.parametrize("seconds", [0.5, 5.0, GATHERING, 10.0 * GATHERING, 1e5])
def test_a_tick_begins_when_its_time_has_come(seconds: float) -> None:
    """Far beyond the time that robots have to join, too."""
    clock = Stopwatch()
    pacing = Pacing(True, STEP / seconds, clock)
    assert not pacing.holds(0, STEP)
    pacing.begin(0, STEP)
    clock.now = 0.999 * seconds
    assert pacing.holds(1, STEP)
    assert pacing.deadline == pytest.approx(min(seconds, clock.now + BEAT))
    clock.now = 1.001 * seconds
    assert not pacing.holds(1, STEP)


def test_slow_motion_goes_on() -> None:
    """A tick that takes longer than robots have to join costs none."""
    with skipped_waits():
        fleet = LocalFleet(two(), speed=STEP / (2.5 * GATHERING))
        for _ in range(4):
            assert fleet.step()
    assert fleet.world.world.exchange.active == (1, 2)
