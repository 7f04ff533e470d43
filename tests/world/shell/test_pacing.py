"""Real time waits for none once all are set up; a tick in slow motion takes as long as is asked."""

from __future__ import annotations

import pytest

from agents.shell.node import RobotNode
from protocol.bus.local import LocalNetwork
from tests.world.driving import STEP, Stopwatch, two
from world.shell.failure_detector import GATHERING
from world.shell.node import WorldNode
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


class Theatre:
    """World and robots of one run on the local bus, and their time."""

    def __init__(self, speed: float, restarts: int = 0) -> None:
        self.clock, self.network = Stopwatch(), LocalNetwork()
        scenario = two()
        bus = self.network.connect()
        self.world = bus.node = WorldNode(
            bus, "slow", scenario, speed=speed, restarts=restarts, clock=self.clock
        )
        self.robots = {robot: self.network.connect() for robot in scenario.ids}
        for robot, robots_bus in self.robots.items():
            robots_bus.node = RobotNode(robots_bus, "slow", robot)
            robots_bus.node.wake(0.0)
        self.play(0.0)

    @property
    def tick(self) -> int:
        return self.world._run.world.tick

    def play(self, seconds: float) -> None:
        """Let time go by, looking whenever the world wants to."""
        end = self.clock.now + seconds
        while True:
            while self.network._ready:
                self.network._ready.popleft().drain()
            self.clock.now = min(max(self.world.deadline, self.clock.now), end)
            if self.clock.now < self.world.deadline:
                return
            self.world.wake(self.clock.now)


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


@pytest.mark.parametrize("seconds", [1.0, 2.5 * GATHERING])
def test_slow_motion_goes_on(seconds: float) -> None:
    theatre = Theatre(STEP / seconds)
    assert theatre.tick == 1  # the first is over at once; the next is held back
    for tick in (2, 3, 4):
        theatre.play(seconds)
        assert theatre.tick == tick


def test_who_goes_while_a_tick_is_held_back_is_waited_for_from_then_on() -> None:
    theatre = Theatre(STEP / (2.0 * GATHERING), restarts=1)
    theatre.play(1.5 * GATHERING)
    theatre.robots[2].close()
    theatre.play(0.75 * GATHERING)  # the next tick is due after 2
    assert theatre.world._run.world.coordinator.lives.awaited == {2}
    bus = theatre.robots[2] = theatre.network.connect()
    bus.node = RobotNode(bus, "slow", 2)
    bus.node.wake(0.0)
    theatre.play(0.0)
    assert theatre.world._run.world.coordinator.active == (1, 2)
