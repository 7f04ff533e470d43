"""The verdict of a run, and its reason. A collision has priority over every other verdict, at the end."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario
from world.judge.record import PastReferee, Record

VERDICTS = ("arrived", "collision", "timeout", "deadlock", "interrupted", "aborted")


class Referee:
    """Measures a run, and decides its verdict.

    arrived: all robots at once within the tolerance of their goals, or all parts at theirs.
    aborted: all robots that are up have arrived, and the others are permanently down.
    deadlock: for the stated time no robot has moved by more than the tolerance, and no process fault,
        partition or order of the scenario is still to come.
    timeout: the limit is reached.

    Args:
        scenario: with the present robots, and the radii that they have with their parts.
        positions: of all disks in the order of robot ids, m.
        parts: straight motions per tick.
        past: of an earlier world.
        obstacles: shapes by number; by default those of the scenario.
    """

    def __init__(
        self,
        scenario: Scenario,
        positions: Sequence[Vector],
        parts: int,
        past: PastReferee | None = None,
        obstacles: Mapping[int, Shape] | None = None,
    ) -> None:
        time = scenario.time
        self.verdict = self.reason = ""  # while the run continues
        self.worlds: tuple[int, ...] = ()  # first ticks of the worlds that continued from others
        self.record = Record(scenario, positions, parts, None if past is None else past.record, obstacles)
        self._carries = bool(scenario.parts)
        self._anchors = {spec.id: spec.start for spec in scenario.robots}
        self._tolerance = time.tolerance
        self._limit, self._patience = scenario.ticks(time.limit), scenario.ticks(time.deadlock)
        self._texts = (f"{time.deadlock:g} s", f"{time.limit:g} s")
        changes = [fault.at for fault in scenario.process] + [part.until for part in scenario.link.partition]
        changes += [order.at for order in scenario.orders]
        self._moved = max((scenario.ticks(at) for at in changes), default=0)
        if past is not None:
            truth = self.record.totals.truth
            self.verdict, self.reason, self.worlds = past.verdict, past.reason, (*past.worlds, truth.tick)
            self._anchors = dict(zip(truth.robots, truth.positions, strict=True))
            self.reset_deadlock_timer(truth.tick)

    @property
    def past(self) -> PastReferee:
        return PastReferee(self.record.past, self.worlds, self.verdict, self.reason)

    def arrived(self, positions: Sequence[Vector]) -> list[int]:
        """Ids of robots within the tolerance of their goal; `positions` in the order of ids, m."""
        goals = self.record.segment.goals
        return [
            robot
            for robot, (x, y), goal in zip(goals.ways, positions, goals.points.tolist(), strict=True)
            if abs(complex(x, y) - goal) <= self._tolerance
        ]

    def reset_deadlock_timer(self, tick: int) -> None:
        """Restart the time without motion at `tick`, after a change that may let robots move."""
        self._moved = max(self._moved, tick)

    def set_goal(self, robot: int, goal: Vector, tick: int) -> None:
        """Set the goal of a robot from `tick` on, m."""
        self.record.set_goal(robot, goal)
        self.reset_deadlock_timer(tick)

    def set_obstacles(self, shapes: Mapping[int, Shape], tick: int) -> None:
        """Set the obstacles from `tick` on, by number."""
        self.record.set_obstacles(shapes)
        self.reset_deadlock_timer(tick)

    def set_fleet(
        self, scenario: Scenario, positions: Sequence[Vector], shapes: Mapping[int, Shape], tick: int
    ) -> None:
        """Set the robots from `tick` on, among obstacles of these shapes."""
        self.record.set_fleet(scenario, positions, shapes)
        self._anchors = {spec.id: self._anchors.get(spec.id, spec.start) for spec in scenario.robots}
        self.reset_deadlock_timer(tick)

    def decide(
        self, tick: int, positions: Sequence[Vector], up: tuple[int, ...], alone: bool, pending: str
    ) -> None:
        """Find out whether the run is over at the start of `tick`, with all disks at `positions` (m, in the
        order of ids), the robots `up`, `alone` if the others will not come back, and `pending` work as text.
        """
        ids, arrived = tuple(self.record.segment.goals.ways), self.arrived(positions)
        missing = [robot for robot in ids if robot not in arrived]
        waiting = self._carries and bool(pending)  # the others may take over the parts of a lost robot
        self._follow(tick, ids, positions)
        if self._carries and not pending:
            self.finish("arrived", "all parts are at their goals")
        elif not missing and not pending:
            self.finish("arrived", "all robots are at their goals")
        elif alone and not waiting and set(up) <= set(arrived):
            down = f"{_names([robot for robot in ids if robot not in up])} down for good"
            self.finish("aborted", f"{down}; the others are at their goals" if up else down)
        elif tick - self._moved >= self._patience:
            self.finish("deadlock", f"no robot moved for {self._texts[0]}; {_unfinished(missing, pending)}")
        elif tick >= self._limit:
            self.finish("timeout", f"{self._texts[1]} are over; {_unfinished(missing, pending)}")

    def finish(self, verdict: str, reason: str) -> None:
        """End the run; a collision has priority, and a second verdict is ignored."""
        if self.verdict:
            return
        totals = self.record.totals
        touches = max(totals.collisions, totals.touched)
        if touches:
            verdict, reason = "collision", f"contacts: {touches}; otherwise {verdict}: {reason}"
        self.verdict, self.reason = verdict, reason

    def _follow(self, tick: int, ids: Sequence[int], positions: Sequence[Vector]) -> None:
        """Note the positions of robots that have moved away from their last noted ones."""
        for robot, place in zip(ids, positions, strict=True):
            if math.dist(place, self._anchors[robot]) > self._tolerance:
                self._anchors[robot] = place
                self._moved = max(self._moved, tick)


def _unfinished(missing: list[int], pending: str) -> str:
    texts = [f"{_names(missing)} not at the goal"] if missing else []
    return ", ".join([*texts, pending] if pending else texts)


def _names(robots: list[int]) -> str:
    verb = "is" if len(robots) == 1 else "are"
    return f"robot{'' if len(robots) == 1 else 's'} {', '.join(map(str, robots))} {verb}"
