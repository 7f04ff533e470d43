"""Ticks per second over stretches of time, as somebody hears them who is told of the clock now and then."""

from __future__ import annotations

from dataclasses import dataclass, field

SETTLING = 0.25  # s at the beginning of a stretch that do not count


@dataclass
class Intervals:
    """Counts ticks over stretches of wall-clock time, told of the world's clock as it comes.

    Attributes:
        rates: ticks per second of each stretch that is over.
    """

    seconds: float
    rates: list[float] = field(default_factory=list)
    _since: float | None = None  # s, monotonic: when the present stretch began
    _ticks: int = 0
    _elapsed: float = 0.0
    _last: tuple[float, int, int] | None = None  # when, run, tick

    def on_clock(self, now: float, run: int, tick: int) -> bool:
        """Whether this news of the clock ends a stretch. Changes from run to run are left out."""
        if self._since is None:
            self._since = now
        last = self._last
        self._last = (now, run, tick)
        if now < self._since + SETTLING:
            return False
        if last is not None and last[1] == run and last[0] >= self._since + SETTLING:
            self._elapsed += now - last[0]
            self._ticks += tick - last[2]
        if now < self._since + SETTLING + self.seconds:
            return False
        self.rates.append(self._ticks / self._elapsed if self._elapsed else 0.0)
        self._since, self._ticks, self._elapsed, self._last = None, 0, 0.0, None
        return True
