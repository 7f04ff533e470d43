"""Large fleets: times and distances that the world and all robots use.

A robot stays in a region around its last known position, and receives the States of the robots that it is
bound to. Every PERIOD the world publishes a summary of all positions, which takes effect LEAD ticks later,
for some robots in one tick and for others in the next. LEAD ticks after a binding begins, a robot is
subscribed to its peer.
"""

from __future__ import annotations

from typing import Final

from protocol.scenario.model import Scenario

PERIOD: Final = 0.5  # s of simulated time
LEAD: Final = 2  # ticks
_SPREAD: Final = 2  # ticks over which summaries take effect: for all robots at once that would be a long tick
_AHEAD: Final = 8  # ticks of motion, besides PERIOD, for which the gap of two leaves room as they are bound
_LEAST: Final = 6  # least ticks of motion in a region
_BOUNDS: Final = 3.0  # error bounds in a region beyond that


def period(scenario: Scenario) -> int:
    """Ticks between two summaries."""
    return max(LEAD + 1, scenario.ticks(PERIOD))


def stagger(scenario: Scenario, robot: int) -> int:
    """Ticks after LEAD in which a summary takes effect for this robot."""
    return robot % min(_SPREAD, period(scenario) - LEAD)


def way(scenario: Scenario, ticks: int) -> float:
    """Longest displacement of a robot in this number of ticks, m."""
    return ticks * scenario.time.step * scenario.control.speed * (1.0 + scenario.actuation.bound)


def slack_of(scenario: Scenario) -> float:
    """Radius of a robot's region less that of its disk, m: half the gap below which two robots are bound."""
    reach = scenario.network.reach
    gap = way(scenario, _AHEAD + period(scenario)) if reach is None else reach
    bound = max((each.bound for each in scenario.sensing), default=0.0)
    return max(0.5 * gap, way(scenario, _LEAST)) + _BOUNDS * bound
