"""Who hears whom in a large fleet: the times and distances that the world and all robots go by.

Every PERIOD the world sums up where everybody is, and says who is near whom. The latter holds LEAD ticks
later, when whoever begins to hear another has subscribed; what the summary says is taken in from then on, by
some robots in one tick and by others in the next. Far robots talk about their line by way of the world, when
one of them may reach it before the next summary could lead to another.
"""

from __future__ import annotations

import math
from typing import Final

from protocol.scenario.model import Scenario

PERIOD: Final = 0.5  # s of simulated time
LEAD: Final = 2  # ticks
_TURNS: Final = 2  # ticks in which robots take in a summary: all in one would make that a long one
_REACH: Final = 1.25  # times the urgent gap; from 2 on, where a line halfway is never urgent, more is heard
_APART: Final = 5.0  # error bounds between two: a line halfway leaves room for all where they can be
_SINGLE: Final = 2.0**-24  # of a coordinate, by which a summary rounds it at most
_TALK: Final = 4  # ticks that it takes two far robots to agree on a line, letters by way of the world


def period(scenario: Scenario) -> int:
    """Ticks between two summaries."""
    return max(LEAD + 1, scenario.ticks(PERIOD))


def turn(scenario: Scenario, robot: int) -> int:
    """Ticks after LEAD in which this robot takes in a summary."""
    return robot % min(_TURNS, period(scenario) - LEAD)


def way(scenario: Scenario, ticks: int) -> float:
    """How far a robot gets at most in so many ticks, m."""
    return ticks * scenario.time.step * scenario.control.speed * (1.0 + scenario.actuation.bound)


def talk(scenario: Scenario) -> int:
    """Ticks that far robots need to agree on a line, injected delays of the link included."""
    delay = scenario.link.delay
    latest = delay[1] if isinstance(delay, tuple) else delay
    return _TALK + 2 * scenario.ticks(latest + scenario.link.jitter)


def urgent(scenario: Scenario) -> float:
    """Gap between disk and line, m, that may be gone before the next summary could lead to another line."""
    return way(scenario, period(scenario) + LEAD + _TURNS - 1 + talk(scenario))


def inner(scenario: Scenario) -> float:
    """Gap between two disks below which they come to be near, m; above, lines need nobody to make room."""
    reach = scenario.network.reach
    return max(_REACH * urgent(scenario) if reach is None else reach, _APART * _doubt(scenario))


def outer(scenario: Scenario) -> float:
    """Gap above which they cease to be near, m."""
    return inner(scenario) + way(scenario, period(scenario))


def _doubt(scenario: Scenario) -> float:
    """How far from where it stands a summary may have a robot, m."""
    around = scenario.workspace.shape.around
    rounding = _SINGLE * (math.hypot(around.x, around.y) + around.radius)
    return rounding + max((each.bound for each in scenario.sensing), default=0.0)
