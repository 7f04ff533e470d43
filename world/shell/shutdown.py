"""The end of a run: robots report, then hear that there is nothing more to do.

A robot learns from a Tick that the run is over, and asks to join again with its report in hand. It is told
to ask again until all have reported, then the verdict. Both waits are bounded, for a robot that does not come
is no reason to keep the others.
"""

from __future__ import annotations

from typing import Any

from protocol import joining
from protocol.messages import Tick
from world.shell.admission import Admissions
from world.shell.pacing import Pacing
from world.shell.run import Phase, Run

SHUTDOWN = 2.0  # s that robots have to report after the end, and to hear that it is over
_ASK_AGAIN = 0.005  # s, for robots that have reported while others have not


class Shutdown:
    """Which robots have reported and which have been notified, and whether that is enough.

    Args:
        admissions: where reports and notifications are kept, by robot.
        pacing: for how long has been waited.
    """

    def __init__(self, admissions: Admissions, pacing: Pacing) -> None:
        self._admissions, self._pacing = admissions, pacing

    def begin(self, run: Run) -> None:
        """There is a verdict: robots are to report."""
        run.phase = Phase.SHUTDOWN
        self._pacing.wait()

    def close(self, run: Run) -> None:
        """The result is published: robots are to leave."""
        run.phase = Phase.CLOSING
        self._pacing.wait()

    def take_report(self, join: joining.Join, run: Run) -> None:
        """A process that asks to join brings its report of the life that it has ended, if any."""
        if run.phase is Phase.SHUTDOWN:
            slot = self._admissions.slots[join.robot]
            slot.health = join.health or slot.health

    def reply(self, join: joining.Join, run: Run) -> joining.Reply | None:
        """What a process that asks to join is told while a run ends; None while it runs."""
        if run.phase is Phase.SHUTDOWN:
            return joining.Wait(_ASK_AGAIN, "the run is being wound up")
        if run.phase is Phase.CLOSING:
            self._admissions.slots[join.robot].notified = True
            return joining.Finished(run.world.verdict)
        return None

    def instead(self, refusal: joining.Reply, robot: int, run: Run) -> joining.Reply:
        """What a process is told that cannot take part: at the end there is nothing to wait for."""
        if run.phase is not Phase.CLOSING or not isinstance(refusal, joining.Wait):
            return refusal
        self._admissions.dismiss(robot)
        return joining.Finished(run.world.verdict)

    def final_ticks(self, run: Run) -> dict[int, Tick]:
        """Ticks that tell the end of the run to robots that have not shown that they know it."""
        admissions, reporting = self._admissions, run.phase is Phase.SHUTDOWN
        return run.final_ticks(admissions.owing_health() if reporting else admissions.unnotified())

    def is_reported(self, run: Run) -> bool:
        """Whether the robots have reported, or had the time to."""
        return run.phase is Phase.SHUTDOWN and (not self._admissions.owing_health() or self._is_overdue())

    def is_over(self, run: Run) -> bool:
        """Whether the processes know that there is nothing more to do, or had the time to hear it."""
        admissions = self._admissions
        left = not (admissions.unnotified() or admissions.is_asked_soon())
        return run.phase is Phase.CLOSING and (left or self._is_overdue())

    def report(self, run: Run, published: int) -> dict[str, Any]:
        """What came of the run up to its verdict, with what the robots reported."""
        healths = (slot.health for slot in self._admissions.slots.values())
        return run.report(healths, published, self._pacing.since)

    def _is_overdue(self) -> bool:
        return self._pacing.waited() > SHUTDOWN
