"""Large fleets: the times and distances that the world and all robots go by.

A robot stays in a region around its last known place, and hears the robots that it is bound to. Every PERIOD
the world sums up where all robots are; what the summary says is taken in LEAD ticks later, by some robots in
one tick and by others in the next. LEAD ticks after it was bound to a robot, a robot has subscribed to it.
"""

from __future__ import annotations

from typing import Final

from protocol.scenario.model import Scenario

PERIOD: Final = 0.5  # s of simulated time
LEAD: Final = 2  # ticks
_TURNS: Final = 2  # ticks in which robots take in a summary: all in one would make that a long one
_AHEAD: Final = 8  # ticks of motion, besides PERIOD, for which the gap of two leaves room as they are bound
_LEAST: Final = 6  # ticks of motion that a region leaves at least
_BOUNDS: Final = 3.0  # error bounds that a region leaves beyond that


def period(scenario: Scenario) -> int:
    """Ticks between two summaries."""
    return max(LEAD + 1, scenario.ticks(PERIOD))


def turn(scenario: Scenario, robot: int) -> int:
    """Ticks after LEAD in which this robot takes in a summary."""
    return robot % min(_TURNS, period(scenario) - LEAD)


def way(scenario: Scenario, ticks: int) -> float:
    """How far a robot gets at most in so many ticks, m."""
    return ticks * scenario.time.step * scenario.control.speed * (1.0 + scenario.actuation.bound)


def slack_of(scenario: Scenario) -> float:
    """How much larger than its disk the region of a robot is, m: half the gap below which two are bound."""
    reach = scenario.network.reach
    gap = way(scenario, _AHEAD + period(scenario)) if reach is None else reach
    bound = max((each.bound for each in scenario.sensing), default=0.0)
    return max(0.5 * gap, way(scenario, _LEAST)) + _BOUNDS * bound
