"""Who took part in a recorded run: the robots of its scenario, and those that came later."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from deploy.telemetry.recording.reading.reader import Recording
from protocol.messages import Tick, Vector


class Participant(NamedTuple):
    """A robot that was there for some of the time.

    Attributes:
        robot: its id.
        radius: m.
        goal: m, where the scenario says; None for who was added by an operator, for no message says it.
        path: m, shape (n, 2), by recorded tick; NaN where its disk was not there.
    """

    robot: int
    radius: float
    goal: Vector | None
    path: np.ndarray

    @property
    def known(self) -> np.ndarray:
        """The part of its path in which it was there."""
        known: np.ndarray = self.path[~np.isnan(self.path[:, 0])]
        return known


def participants(recording: Recording) -> list[Participant]:
    """In the order of ids."""
    scenario, truths = recording.scenario, recording.truths
    specs = {spec.id: spec for spec in (*scenario.newcomers, *scenario.robots)}
    robots: list[int] = truths.robots.tolist()
    radii = _announced(recording, set(robots).difference(specs))
    return [
        Participant(
            robot,
            specs[robot].radius if robot in specs else radii.get(robot, 0.0),
            specs[robot].goal if robot in specs else None,
            truths.positions[:, index],
        )
        for index, robot in enumerate(robots)
    ]


def _announced(recording: Recording, robots: set[int]) -> dict[int, float]:
    """Radii of robots that operators added, by the roster that others were told, m."""
    radii: dict[int, float] = {}
    for tick in recording.said(Tick) if robots else ():
        members = () if tick.roster is None else tick.roster.members
        radii.update({each.robot: each.radius for each in members if each.robot in robots})
        if len(radii) == len(robots):
            break
    return radii
