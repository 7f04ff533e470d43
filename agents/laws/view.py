"""What a control law is given in every tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from mypy_extensions import mypyc_attr

from agents.peers.neighbours import Neighbours
from protocol.geometry import Shape
from protocol.messages import Vector


@final
@mypyc_attr(acyclic=True)
class View:
    """One tick as its robot sees it. Nothing in it may be changed, or kept beyond the tick.

    Args:
        tick: that begins.
        position: own, m.
        goal: own, m; it may be another one in the next tick.
        displacement: really executed during the last tick, m.
        neighbours: peers as last heard, and disks that stand.
        things: what stands and is no robot.

    Attributes: as given.
    """

    __slots__ = ("displacement", "goal", "neighbours", "position", "things", "tick")

    def __init__(
        self,
        *,
        tick: int,
        position: Vector,
        goal: Vector,
        displacement: Vector,
        neighbours: Neighbours,
        things: Sequence[Shape] = (),
    ) -> None:
        self.tick, self.position, self.goal = tick, position, goal
        self.displacement, self.neighbours, self.things = displacement, neighbours, things
