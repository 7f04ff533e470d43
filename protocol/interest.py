"""Who hears whom in a large fleet: the times and distances that the world and all robots go by.

Every PERIOD the world sums up where everybody is, and says who is near whom; both hold LEAD ticks later, when
whoever begins to hear another has subscribed. Far robots talk about their line by way of the world, when
one of them may reach it before the next summary could lead to another.
"""

from __future__ import annotations

from typing import Final

from protocol.scenario.model import Scenario

PERIOD: Final = 0.5  # s of simulated time
LEAD: Final = 2  # ticks
_APART: Final = (
    5.0  # error bounds between two, beyond which a line halfway leaves room for all where they can be
)
_TALK: Final = 4  # ticks that it takes two far robots to agree on a line, letters by way of the world


def period(scenario: Scenario) -> int:
    """Ticks between two summaries."""
    return max(LEAD + 1, scenario.ticks(PERIOD))


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
    return way(scenario, period(scenario) + LEAD + talk(scenario))


def inner(scenario: Scenario) -> float:
    """Gap between two disks below which they come to be near, m: above, a line halfway is not urgent, and
    nobody has to make room for it."""
    reach, doubt = scenario.network.reach, max((each.bound for each in scenario.sensing), default=0.0)
    return max(2.0 * urgent(scenario) if reach is None else reach, _APART * doubt)


def outer(scenario: Scenario) -> float:
    """Gap above which they cease to be near, m."""
    return inner(scenario) + 2.0 * way(scenario, period(scenario))
