"""What a control law is to a robot: from what it sees to the velocity that it wants."""

from __future__ import annotations

import math
from typing import Protocol

from agents.laws.view import View
from protocol.messages import Vector
from protocol.scenario.model import Scenario


class Law(Protocol):
    """One law for one life of one robot; the safety filter comes after it.

    The goal comes with every call: it may change while the robot drives, and no law keeps it.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        """`robot`: id of the robot to control."""

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s, at most the speed limit. Called once in every tick in which the own place is
        known."""
        ...

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i| at an own position (m) with the peers as of the last `velocity`, m: peers at the common pace
        go by it. Unless a law knows better, that of the attraction alone."""
        return 2.0 * math.hypot(position[0] - goal[0], position[1] - goal[1])
