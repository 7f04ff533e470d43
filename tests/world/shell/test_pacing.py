"""Real time waits for nobody once all have set themselves up."""

from world.shell.pacing import FIRST, Pacing

STEP = 0.1


def test_the_first_tick_of_real_time_waits_but_not_for_ever() -> None:
    now = 0.0
    pacing = Pacing(False, 0.0, lambda: now)
    pacing.begin(0, STEP)
    now = pacing.deadline
    assert now == STEP
    while pacing.prolongs(0, now):
        assert now < pacing.deadline <= now + STEP
        now = pacing.deadline
    assert now >= FIRST
    pacing.begin(1, STEP)
    assert pacing.since == now  # nothing is caught up with
    now = pacing.deadline
    assert not pacing.prolongs(1, now)
