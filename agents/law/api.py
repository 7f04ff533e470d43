"""The interface of a control law, and its input in every tick: a library for custom laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol, final

from mypy_extensions import mypyc_attr

from agents.peers.neighbours import Neighbours
from protocol.geometry import Shape
from protocol.messages import Vector
from protocol.scenario.model import Scenario


@final
@mypyc_attr(acyclic=True)
class View:
    """One tick as its robot sees it. Nothing in it may be changed, or kept beyond the tick.

    Attributes:
        tick: that begins.
        position: own, m.
        goal: own, m; it may be another one in the next tick.
        displacement: really executed during the last tick, m.
        neighbours: peers as last received, and static disks.
        obstacles: static obstacles.
    """

    __slots__ = ("displacement", "goal", "neighbours", "obstacles", "position", "tick")

    def __init__(
        self,
        *,
        tick: int,
        position: Vector,
        goal: Vector,
        displacement: Vector,
        neighbours: Neighbours,
        obstacles: Sequence[Shape] = (),
    ) -> None:
        self.tick, self.position, self.goal = tick, position, goal
        self.displacement, self.neighbours, self.obstacles = displacement, neighbours, obstacles


class Law(Protocol):
    """One law for one life of one robot; the safety filter comes after it.

    The goal comes with every call: it may change while the robot drives, and no law keeps it.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        """`robot`: id of the robot to control."""

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s, at most the speed limit; once a tick in which the own place is known."""
        ...

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i| at an own position (m) with the peers as of the last `velocity`, m: peers at the common pace
        go by it. Unless a law knows better, that of the attraction alone."""
        return 2.0 * math.hypot(position[0] - goal[0], position[1] - goal[1])
