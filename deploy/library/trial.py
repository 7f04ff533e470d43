"""A law from outside before anything starts: what it returns, and how long it takes."""

from __future__ import annotations

import time

from agents.law import View, choose
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.errors import UsageError
from protocol.scenario.model import Scenario

TRIES = 5  # the quickest counts: others may have waited for the processor


def try_out(scenario: Scenario) -> None:
    """Let a law from outside make some steps as the first robot at the start.

    Raises:
        UsageError: there is no such law, or a step takes longer than a period.
        LawError: it fails, or does not return a velocity.
    """
    if ":" not in scenario.control.law:
        return
    robot = scenario.ids[0]
    law, own = choose(scenario, robot), scenario.spec(robot)
    neighbours = _neighbours(scenario, robot)
    quickest = float("inf")
    for tick in range(TRIES):
        view = View(
            tick=tick,
            position=own.start,
            goal=own.goal,
            displacement=(0.0, 0.0),
            neighbours=neighbours,
            things=tuple(scenario.shapes.values()),
        )
        begin = time.perf_counter()
        law.velocity(view)
        quickest = min(quickest, time.perf_counter() - begin)
        law.slice_norm(own.start, own.goal)
    if quickest > scenario.time.step:
        raise UsageError(
            f"control.law: a step of {scenario.control.law} takes {1e3 * quickest:.3g} ms, longer than a "
            f"period of {1e3 * scenario.time.step:g} ms: make it quicker, or time.step longer"
        )


def _neighbours(scenario: Scenario, robot: int) -> Neighbours:
    """Everybody else as heard in the first tick."""
    others = [spec for spec in scenario.robots if spec.id != robot]
    heard = Neighbours({spec.id: spec.radius for spec in others})
    for spec in others:
        x, y = spec.start
        gamma = (x - spec.goal[0]) ** 2 + (y - spec.goal[1]) ** 2
        pull = 2.0 * gamma**0.5
        heard.on_state(PeerState(spec.id, 1, 0, True, x, y, 0.0, gamma, pull, 0.0, 0.0, radius=spec.radius))
    return heard
