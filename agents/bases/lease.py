"""For how long a robot may move without another word of the coordinator.

The coordinator says in each Tick which of the robot's Commands it has heard last. It takes nobody for
standing whose lease may not be over. The lease runs from the sending of that Command, by this robot's own
clock: no two clocks have to agree on the time, only on how fast it goes.
"""

from __future__ import annotations

import math


class Lease:
    """One life's lease.

    Args:
        duration: s.

    Attributes:
        until: when it ends, s, by the clock of this process.
    """

    def __init__(self, duration: float) -> None:
        self.until = -math.inf
        self._duration = duration
        self._sent: dict[int, float] = {}

    def sent(self, tick: int, now: float) -> None:
        """The Command of a tick is about to be sent, perhaps once more."""
        self._sent.setdefault(tick, now)

    def heard(self, tick: int | None) -> None:
        """The coordinator has the Command of that tick."""
        if tick is None or tick not in self._sent:
            return
        self.until = max(self.until, self._sent[tick] + self._duration)
        self._sent = {other: when for other, when in self._sent.items() if other > tick}
