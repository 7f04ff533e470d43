"""The verdict: how a run ended, and why. A collision outranks everything else, at the end."""

from __future__ import annotations

import numpy as np

from protocol.scenario import Scenario
from world.clearance import Plane

VERDICTS = ("arrived", "collision", "timeout", "deadlock", "interrupted", "aborted")


class Judge:
    """Decides tick by tick whether the run is over.

    arrived: all robots at once within the tolerance of their goals.
    aborted: all robots that are up have arrived, and the others are down for good.
    deadlock: for the stated time no robot got further than the tolerance from where it was,
        and nothing that the scenario has scheduled (process faults, partitions) is still to change that.
    timeout: the limit is reached.
    """

    def __init__(self, scenario: Scenario, ids: tuple[int, ...]) -> None:
        time = scenario.time
        self._ids = ids
        self._goals: Plane = np.array([complex(*scenario.spec(robot).goal) for robot in ids])
        self._anchor: Plane = np.array([complex(*scenario.spec(robot).start) for robot in ids])
        self._tolerance = time.tolerance
        self._limit = scenario.ticks(time.limit)
        self._patience = scenario.ticks(time.deadlock)
        self._texts = (f"{time.deadlock:g} s", f"{time.limit:g} s")
        changes = [fault.at for fault in scenario.process] + [part.until for part in scenario.link.partition]
        self._moved = max((scenario.ticks(at) for at in changes), default=0)

    def arrived(self, positions: Plane) -> list[int]:
        """Ids of robots within the tolerance of their goal."""
        near = np.abs(positions - self._goals) <= self._tolerance
        return [robot for robot, here in zip(self._ids, near.tolist(), strict=True) if here]

    def judge(self, tick: int, positions: Plane, up: tuple[int, ...], gone_for_good: bool) -> tuple[str, str]:
        """Verdict and reason at the start of `tick`, `("", "")` while the run goes on.

        Args:
            positions: shape (p,), complex, m.
            up: ids of robots that take part.
            gone_for_good: whether those that are not up will not come back.
        """
        arrived = self.arrived(positions)
        if len(arrived) == len(self._ids):
            return "arrived", "all robots are at their goals"
        if gone_for_good and set(up) <= set(arrived):
            return "aborted", _aborted(self._ids, up)
        self._follow(tick, positions)
        if tick - self._moved >= self._patience:
            return "deadlock", f"nobody moved for {self._texts[0]}; {_not_there(self._ids, arrived)}"
        if tick >= self._limit:
            return "timeout", f"{self._texts[1]} are over; {_not_there(self._ids, arrived)}"
        return "", ""

    def _follow(self, tick: int, positions: Plane) -> None:
        """Take note of robots that got away from where they were last noted."""
        away = np.abs(positions - self._anchor) > self._tolerance
        if away.any():
            self._anchor[away] = positions[away]
            self._moved = max(self._moved, tick)


def _aborted(ids: tuple[int, ...], up: tuple[int, ...]) -> str:
    down = _names([robot for robot in ids if robot not in up])
    return f"{down} down for good; the others are at their goals" if up else f"{down} down for good"


def _not_there(ids: tuple[int, ...], arrived: list[int]) -> str:
    return f"{_names([robot for robot in ids if robot not in arrived])} not at the goal"


def _names(robots: list[int]) -> str:
    verb = "is" if len(robots) == 1 else "are"
    return f"robot{'' if len(robots) == 1 else 's'} {', '.join(map(str, robots))} {verb}"
