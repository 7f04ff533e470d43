"""The referee: takes note of everything that happens in a run, and says when and how it is over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mypy_extensions import mypyc_attr

from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.judge.goals import Goals
from world.judge.record import Record
from world.judge.touches import Touches
from world.judge.verdict import Judge


@mypyc_attr(allow_interpreted_subclasses=True)
class Referee:
    """What is measured of a run, and its verdict.

    Args:
        positions: of all disks in the order of robot ids, m.
        parts: straight motions that a tick consists of.

    Attributes:
        verdict, reason: empty while the run goes on.
        record: of the truth.
        touches: contacts that the plant saw by itself.
    """

    def __init__(self, scenario: Scenario, positions: Sequence[Vector], parts: int) -> None:
        goals = Goals(scenario)
        self.verdict = ""
        self.reason = ""
        self.record = Record(scenario, goals, positions, parts)
        self.touches = Touches()
        self._judge = Judge(scenario, goals)
        self._parts = bool(scenario.parts)

    def arrived(self, positions: Sequence[Vector]) -> list[int]:
        """Ids of robots within the tolerance of their goal."""
        return self._judge.arrived(positions)

    def disturb(self, tick: int) -> None:
        """Something happened at `tick` after which somebody may move who stood still until then."""
        self._judge.disturb(tick)

    def redirect(self, robot: int, goal: Vector, tick: int) -> None:
        """From `tick` on a robot is to go to `goal`, m."""
        self.record.redirect(robot, goal)
        self._judge.disturb(tick)

    def surround(self, shapes: Mapping[int, Shape], tick: int) -> None:
        """From `tick` on these things stand, by number."""
        self.record.surround(shapes)
        self._judge.disturb(tick)

    def recast(
        self, scenario: Scenario, positions: Sequence[Vector], shapes: Mapping[int, Shape], tick: int
    ) -> None:
        """Robots came and went at `tick`, among things of these shapes."""
        self.record.recast(scenario, positions, shapes)
        self._judge.recast(scenario, tick)

    def decide(
        self, tick: int, positions: Sequence[Vector], up: tuple[int, ...], alone: bool, pending: str
    ) -> None:
        """Find out whether the run is over at the start of `tick`; arguments as of `Judge.judge`."""
        waiting = self._parts and bool(pending)  # robots that are left may do what another cannot any more
        verdict, reason = self._judge.judge(tick, positions, up, alone and not waiting, pending)
        if self._parts and not pending:
            verdict, reason = "arrived", "all parts are at their goals"
        if verdict:
            self.finish(verdict, reason)

    def finish(self, verdict: str, reason: str) -> None:
        """End the run; a collision outranks, and a second verdict is ignored."""
        if self.verdict:
            return
        touches = max(len(self.record.contacts.all), len(self.touches.all))
        if touches:
            verdict, reason = "collision", f"contacts: {touches}; otherwise {verdict}: {reason}"
        self.verdict, self.reason = verdict, reason
