"""Begin and end of ticks by the wall clock: at once, in real time, or as a viewer steers."""

from __future__ import annotations

import time
from collections.abc import Callable

from protocol.operations import Steering

_AGAIN = 0.01  # s between looks at missing robots in the first tick
BEAT = 0.1  # s between looks while nothing happens
FIRST = 3.0  # s, longest first tick of real time, in which robots initialise
REPEAT = 0.5  # s until a tick without all commands is repeated; then three times that


class Pacing:
    """The wall clock of one world.

    Args:
        lockstep: whether ticks wait for the robots, or end after their time.
        speed: simulated seconds per second in lock-step, 0 for no limit.
        clock: time, s.
    """

    def __init__(self, lockstep: bool, speed: float, clock: Callable[[], float] = time.monotonic) -> None:
        self.lockstep = lockstep
        self.steering = Steering(speed=speed)  # viewers' settings of a lock-step clock
        self._clock = clock
        self._repeat = REPEAT
        self.wait()
        self._began = self.since

    def now(self) -> float:
        return self._clock()

    def wait(self) -> None:
        """Begin a wait."""
        self.since = self._clock()  # beginning of the present tick or wait, s, by the clock
        self.look_again(self.since)

    def look_again(self, now: float) -> None:
        """Schedule another look."""
        self.deadline = now + BEAT  # latest time of the next look, s, by the clock

    def waited(self) -> float:
        """Duration of the wait, s."""
        return self._clock() - self.since

    @property
    def has_repeated(self) -> bool:
        """Whether the present tick was repeated."""
        return self._repeat > REPEAT

    def repeats(self) -> bool:
        """Whether it is time to repeat the present Ticks, since messages may have been lost."""
        if self.waited() < self._repeat:
            return False
        self._repeat *= 3.0
        return True

    def holds(self, tick: int, step: float) -> bool:
        """Whether a viewer's pause or speed delays `tick`, to `step / speed` s after the beginning of the one
        before.
        """
        steering = self.steering
        if steering.speed > 0.0 and not steering.paused and tick > 0:
            due = self._began + step / steering.speed
            now = self._clock()
            if now < due:
                self.deadline = min(due, now + BEAT)
                return True
        return not steering.allow()

    def prolongs(self, tick: int, now: float) -> bool:
        """Whether `tick` of real time waits for missing Commands: only the first does, for a while."""
        if tick > 0 or now >= self.since + FIRST:
            return False
        self.deadline = now + _AGAIN
        return True

    def begin(self, tick: int, step: float) -> None:
        """Begin `tick`: in real time it ends after `step` s."""
        now = self._began = self._clock()
        if self.lockstep:
            self.begin_again()
        else:
            due = self.since + step if tick > 0 else now
            self.since = due if now < due + step else now  # a tick late: do not catch up
            self.deadline = self.since + step

    def begin_again(self) -> None:
        """Begin or repeat the present tick of lock-step."""
        self.since, self._repeat = self._clock(), REPEAT
        self.look_again(self.since)
