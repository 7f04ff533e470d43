"""The interface of a control law, and its input in each tick, for custom laws."""

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
class View:  # no dataclass: compiled, one takes ten times as long to make
    """One tick as its robot sees it. Nothing in it may be changed, or kept beyond the tick.

    Attributes:
        tick: that begins.
        position: own, m.
        goal: own, m; it may be another one in the next tick.
        displacement: really executed during the last tick, m.
        neighbours: peers as last received, and static disks.
        obstacles: that are static.
    """

    def __init__(
        self,
        tick: int,
        position: Vector,
        goal: Vector,
        displacement: Vector,
        neighbours: Neighbours,
        obstacles: Sequence[Shape] = (),
    ) -> None:
        self.tick, self.position, self.goal = tick, position, goal
        self.displacement, self.neighbours, self.obstacles = displacement, neighbours, obstacles


def attraction(position: Vector, goal: Vector) -> float:
    """|D_i| of the attraction alone, m."""
    return 2.0 * math.hypot(position[0] - goal[0], position[1] - goal[1])


@mypyc_attr(native_class=False)  # else no law that is not compiled could inherit from it
class Law(Protocol):
    """The law of one life of one robot; the safety filter follows it.

    The goal is part of each call, since it may change during the run.
    """

    def __init__(self, scenario: Scenario, robot: int) -> None:
        """`robot`: id of the robot to control."""

    def velocity(self, view: View) -> Vector:
        """Desired velocity, m/s, at most the speed limit; called in every tick with a known position."""
        ...

    def slice_norm(self, position: Vector, goal: Vector) -> float:
        """|D_i| at a position (m) among the peers of the last `velocity`, m; by default of the attraction."""
        return attraction(position, goal)
