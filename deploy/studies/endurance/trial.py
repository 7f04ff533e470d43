"""What is asked of a fleet that is to endure."""

from __future__ import annotations

from dataclasses import dataclass

from deploy.run.options import RunOptions


@dataclass(frozen=True)
class Trial:
    """What is asked of a fleet."""

    robots: int
    minutes: float
    options: RunOptions
    kill_every: float = 0.0  # s; 0: nobody is killed. Needs processes that are started again.
    cut_every: float = 0.0  # s; 0: no link is cut. Needs a router.

    @property
    def disturbed(self) -> bool:
        """Whether anything is done to the fleet."""
        return self.kill_every > 0.0 or self.cut_every > 0.0
