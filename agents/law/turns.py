"""One mover at a time: whatever the law, a robot moves in its turn alone.

Along the motion of one robot the navigation function descends as along that of all: what each does is its own
slice of the same gradient. So it is minimized robot by robot, as by coordinate descent.
"""

from __future__ import annotations

from typing import final

from protocol.scenario.model import Scenario


@final
class Turn:
    """When it is the turn of one robot.

    Args:
        place: of the robot in the order of ids, from 0.
        robots: how many take turns.
        ticks: that a turn lasts.
    """

    def __init__(self, place: int, robots: int, ticks: int) -> None:
        self._place, self._robots, self._ticks = place, robots, ticks

    def has_come(self, tick: int) -> bool:
        """Whether the robot may move in a tick."""
        return tick // self._ticks % self._robots == self._place


def turn_of(scenario: Scenario, robot: int) -> Turn | None:
    """The turn of a robot; None where all move at once, as they do unless `control.turn` is given."""
    if scenario.control.turn is None:
        return None
    ids = scenario.ids
    return Turn(ids.index(robot), len(ids), scenario.ticks(scenario.control.turn))
