"""The verdict: how a run ended, and why; and the referee, which takes note of everything that happens in it.

A collision outranks everything else, at the end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mypy_extensions import mypyc_attr

from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.judge.contacts import Touches
from world.judge.goals import Goals
from world.judge.record import Record

VERDICTS = ("arrived", "collision", "timeout", "deadlock", "interrupted", "aborted")


@mypyc_attr(allow_interpreted_subclasses=True)
class Judge:
    """Decides tick by tick whether the run is over.

    arrived: all robots at once within the tolerance of their goals.
    aborted: all robots that are up have arrived, and the others are down for good.
    deadlock: for the stated time no robot got further than the tolerance from where it was,
        and nothing that the scenario has scheduled (process faults, partitions, orders) is still to change
        that.
    timeout: the limit is reached.
    """

    def __init__(self, scenario: Scenario, goals: Goals) -> None:
        time = scenario.time
        self._ids, self._goals = goals.ids, goals
        self._anchors = [complex(*scenario.spec(robot).start) for robot in goals.ids]
        self._tolerance = time.tolerance
        self._limit = scenario.ticks(time.limit)
        self._patience = scenario.ticks(time.deadlock)
        self._texts = (f"{time.deadlock:g} s", f"{time.limit:g} s")
        changes = [fault.at for fault in scenario.process] + [part.until for part in scenario.link.partition]
        changes += [order.at for order in scenario.orders]
        self._moved = max((scenario.ticks(at) for at in changes), default=0)

    def arrived(self, positions: Sequence[Vector]) -> list[int]:
        """Ids of robots within the tolerance of their goal; `positions` in the order of ids, m."""
        return [
            robot
            for robot, (x, y), goal in zip(self._ids, positions, self._goals.points.tolist(), strict=True)
            if abs(complex(x, y) - goal) <= self._tolerance
        ]

    def judge(
        self,
        tick: int,
        positions: Sequence[Vector],
        up: tuple[int, ...],
        gone_for_good: bool,
        pending: str = "",
    ) -> tuple[str, str]:
        """Verdict and reason at the start of `tick`, `("", "")` while the run goes on.

        Args:
            positions: in the order of ids, m.
            up: ids of robots that take part.
            gone_for_good: whether those that are not up will not come back.
            pending: what is still to come although robots are at their goals, in words; "" for nothing.
        """
        arrived = self.arrived(positions)
        if len(arrived) == len(self._ids) and not pending:
            return "arrived", "all robots are at their goals"
        if gone_for_good and set(up) <= set(arrived):
            return "aborted", _aborted(self._ids, up)
        self._follow(tick, positions)
        if tick - self._moved >= self._patience:
            return (
                "deadlock",
                f"nobody moved for {self._texts[0]}; {_unfinished(self._ids, arrived, pending)}",
            )
        if tick >= self._limit:
            return "timeout", f"{self._texts[1]} are over; {_unfinished(self._ids, arrived, pending)}"
        return "", ""

    def recast(self, scenario: Scenario, tick: int) -> None:
        """Robots came and went at `tick`; the goals are recast already."""
        anchors = dict(zip(self._ids, self._anchors, strict=True))
        self._ids = scenario.ids
        self._anchors = [anchors.get(robot, complex(*scenario.spec(robot).start)) for robot in scenario.ids]
        self.disturb(tick)

    def disturb(self, tick: int) -> None:
        """Somebody was given another goal at `tick`: who stood still until then may move now."""
        self._moved = max(self._moved, tick)

    def _follow(self, tick: int, positions: Sequence[Vector]) -> None:
        """Take note of robots that got away from where they were last noted."""
        for index, (x, y) in enumerate(positions):
            place = complex(x, y)
            if abs(place - self._anchors[index]) > self._tolerance:
                self._anchors[index] = place
                self._moved = max(self._moved, tick)


def _aborted(ids: tuple[int, ...], up: tuple[int, ...]) -> str:
    down = _names([robot for robot in ids if robot not in up])
    return f"{down} down for good; the others are at their goals" if up else f"{down} down for good"


def _unfinished(ids: tuple[int, ...], arrived: list[int], pending: str) -> str:
    away = [robot for robot in ids if robot not in arrived]
    return ", ".join(text for text in (f"{_names(away)} not at the goal" if away else "", pending) if text)


def _names(robots: list[int]) -> str:
    verb = "is" if len(robots) == 1 else "are"
    return f"robot{'' if len(robots) == 1 else 's'} {', '.join(map(str, robots))} {verb}"


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
