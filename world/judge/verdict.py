"""The verdict: how a run ended, and why. A collision outranks everything else, at the end."""

from __future__ import annotations

from collections.abc import Sequence

from mypy_extensions import mypyc_attr

from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.judge.goals import Goals

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
