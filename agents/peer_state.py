"""A peer's State as a robot keeps it: the same numbers, at hand for whoever computes with them."""

from __future__ import annotations

from typing import final

from protocol.messages import State

Vector = tuple[float, float]


@final
class PeerState:
    """See `protocol.messages.State` for the fields.

    Args:
        state: the peer's.
        robot: own id; what the State says of other pairs is left out.

    Attributes:
        placed: whether the peer knows where it is.
        x, y: its estimate of that, m; 0 unless `placed`.
        vx, vy: the velocity that its law asks for, m/s.
    """

    __slots__ = (
        "answers",
        "bound",
        "gamma",
        "incarnation",
        "placed",
        "proposals",
        "robot",
        "slice",
        "tick",
        "vx",
        "vy",
        "x",
        "y",
    )

    def __init__(self, state: State, robot: int) -> None:
        self.robot, self.incarnation, self.tick = state.robot, state.incarnation, state.tick
        position = state.position
        self.placed = position is not None
        self.x, self.y = (0.0, 0.0) if position is None else position
        self.bound, self.gamma, self.slice = state.bound, state.gamma, state.slice
        self.vx, self.vy = state.desired
        self.proposals = tuple([each for each in state.proposals if each.peer == robot])
        self.answers = tuple([each for each in state.answers if each.peer == robot])

    @property
    def position(self) -> Vector | None:
        """As in the State, m."""
        return (self.x, self.y) if self.placed else None

    @property
    def desired(self) -> Vector:
        """As in the State, m/s."""
        return self.vx, self.vy

    @property
    def total(self) -> float:
        """The sum of all numbers here that may be infinite, or none: finite only if all of them are."""
        total = self.x + self.y + self.bound + self.gamma + self.slice + self.vx + self.vy
        for line in self.proposals:
            total += line.nx + line.ny + line.offset
        return total
