"""How long a process that failed waits before it is started again: longer each time it fails soon after.

Exponential with a cap, as in systemd's RestartSteps and Kubernetes' CrashLoopBackOff: one that cannot live
costs next to nothing, and the others keep the processor.
"""

from __future__ import annotations

from dataclasses import dataclass

STEADY = 60.0  # s; who has lived so long has not failed in a row
_FIRST = 0.25  # s, after the second failure in a row; after the first there is no wait
_LONGEST = 10.0  # s, well within what a world waits for a robot to join


@dataclass
class Backoff:
    """The waits of one process."""

    _in_a_row: int = 0

    def wait(self, lived: float) -> float:
        """How long to wait, s, after a failure at the age of `lived` s."""
        if lived >= STEADY:
            self._in_a_row = 0
        self._in_a_row += 1
        return 0.0 if self._in_a_row == 1 else min(_LONGEST, _FIRST * 2.0 ** min(self._in_a_row - 2, 16))
