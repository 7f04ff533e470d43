"""What a control law is to a robot: from what it knows to the velocity that it wants."""

from __future__ import annotations

from typing import Protocol

from agents.peers.neighbours import Neighbours

Vector = tuple[float, float]


class Law(Protocol):
    """One law for one life of one robot; the safety filter comes after it."""

    def velocity(self, position: Vector, displacement: Vector, neighbours: Neighbours, tick: int) -> Vector:
        """Desired velocity, m/s, at most the speed limit.

        Args:
            position: own position, m.
            displacement: really executed during the last tick, m.
            neighbours: peers as last heard.
            tick: the tick that begins.
        """

    def slice_norm(self, position: Vector) -> float:
        """|D_i| at an own position with the peers as of the last `velocity`, m: for the common pace."""
