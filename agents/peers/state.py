"""A peer's State as a robot keeps it: the same numbers, at hand for whoever computes with them."""

from __future__ import annotations

import math
from typing import NamedTuple, final

from mypy_extensions import mypyc_attr

from protocol.messages import Answer, Claim, Proposal, State, Vector
from protocol.process.newest import keeps_newest
from protocol.scenario.model import Scenario


@mypyc_attr(acyclic=True)
class Peer:
    """A disk as a robot knows it: centre and radius in m, gamma_j = |b_j - g_j|^2 in m^2 (0 if fixed)."""

    __slots__ = ("gamma", "radius", "x", "y")

    def __init__(self, x: float, y: float, radius: float, gamma: float) -> None:
        self.x, self.y, self.radius, self.gamma = x, y, radius, gamma


@final
@mypyc_attr(acyclic=True)
class PeerState(Peer):
    """What a State says to one of those who hear it; see `protocol.messages.State` for what is not here.

    Laws and lines look at its numbers several times a tick, for every peer. In a message these are objects
    of Python: compiled, a pass over 63 peers takes 1.7 us by the messages themselves, and 0.1 us so.

    Args:
        placed: whether the peer knows where it is.
        x, y: its estimate of that, m; 0 unless `placed`.
        vx, vy: the velocity that its law asks for, m/s.
        radius: the peer's, m; see `size`.
        claim: which part it fetches or carries.

    Attributes: as given.
    """

    __slots__ = (
        "answers",
        "bound",
        "claim",
        "incarnation",
        "placed",
        "proposals",
        "robot",
        "slice",
        "tick",
        "vx",
        "vy",
    )

    def __init__(
        self,
        robot: int,
        incarnation: int,
        tick: int,
        placed: bool,
        x: float,
        y: float,
        bound: float,
        gamma: float,
        slice_norm: float,
        vx: float,
        vy: float,
        *,
        radius: float = 0.0,
        proposals: tuple[Proposal, ...] = (),
        answers: tuple[Answer, ...] = (),
        claim: Claim | None = None,
    ) -> None:
        self.robot, self.incarnation, self.tick = robot, incarnation, tick
        self.placed, self.x, self.y = placed, x, y
        self.radius, self.bound, self.gamma, self.slice = radius, bound, gamma, slice_norm
        self.vx, self.vy = vx, vy
        self.proposals, self.answers = proposals, answers
        self.claim = claim

    def size(self, told: float) -> None:
        """To be called as it is heard: the peer's disk is of the radius that the roster of that tick says, m,
        or of a larger one that it claims to be. As it arrives another roster may be known."""
        self.radius = told if self.claim is None else max(told, self.claim.radius)

    @property
    def position(self) -> Vector | None:
        """As in the State, m."""
        return (self.x, self.y) if self.placed else None

    @property
    def desired(self) -> Vector:
        """As in the State, m/s."""
        return self.vx, self.vy


class Plausible(NamedTuple):
    """What a State can truly say in a scenario; a robot that says more is sick, or lies.

    Attributes:
        place: of either coordinate, m.
        bound: m.
        gamma: m^2.
        part: radius of the largest part, m; 0 if there is none.
    """

    place: float
    bound: float
    gamma: float
    part: float

    def allows(self, state: PeerState) -> bool:
        """Whether all that it says is plausible."""
        place = self.place
        near = -place <= state.x <= place and -place <= state.y <= place
        return near and state.bound <= self.bound and state.gamma <= self.gamma

    def locates(self, position: Vector, bound: float) -> bool:
        """Whether a robot knows where it is, if all that it knows is this."""
        return abs(position[0]) <= self.place and abs(position[1]) <= self.place and bound <= self.bound


@keeps_newest
def plausible(scenario: Scenario) -> Plausible:
    """Of a scenario: twice as far as its workspace reaches, and what follows from that."""
    around = scenario.workspace.shape.around
    reach = math.hypot(around.x, around.y) + around.radius
    part = max((each.radius for each in scenario.parts), default=0.0)
    return Plausible(2.0 * reach, 4.0 * reach, (4.0 * reach) ** 2, part)


def addressed_to(robot: int, state: State, radius: float = 0.0) -> PeerState:
    """What `state` says to `robot`, without lines of other pairs; for the rest see `PeerState`."""
    placed = state.position is not None
    x, y = state.position or (0.0, 0.0)
    found = PeerState(
        state.robot,
        state.incarnation,
        state.tick,
        placed,
        x,
        y,
        state.bound,
        state.gamma,
        state.slice,
        *state.desired,
        radius=radius,
        proposals=tuple([each for each in state.proposals if each.peer == robot]),
        answers=tuple([each for each in state.answers if each.peer == robot]),
        claim=state.claim,
    )
    found.size(radius)
    return found
