"""The only path of a velocity to the base: the nearest to the law's that satisfies lines, region and
workspace.

It is zero until the robot has adopted a region. The same constraints tighten the estimate of its position.
"""

from __future__ import annotations

from math import inf
from typing import Final, final

from agents.bodies import BodyModel
from agents.estimate import Estimate
from agents.lines.boundary import Boundary, RoundBoundary, boundary_of
from agents.lines.own_set import Polygon
from agents.lines.safe_velocity import Limits
from agents.lines.separating_lines import SeparatingLines
from protocol.messages import STILL, Vector
from protocol.scenario.model import Scenario

CORNERS: Final = 4  # most cuts of the own set by workspace and region in a tick


@final
class SafetyFilter:
    """All constraints of one life of one robot; with `filter = "none"` they are known, but not obeyed."""

    def __init__(self, scenario: Scenario, robot: int, radius: float, body: BodyModel) -> None:
        self.obeyed = scenario.control.filter == "separating-lines"
        self.radius = radius  # of the own disk, m
        self.lines = SeparatingLines(
            robot,
            radius,
            speed=scenario.control.speed * (1.0 + scenario.actuation.bound),
            period=scenario.time.step,
            reach=body.reach,
            standoff=body.standoff,
        )
        self._body, self._room = body, scenario.workspace.shape
        self._workspace = boundary_of(self._room, radius)
        self._located = False  # whether the position is certain

    def locate(self, tick: int, estimate: Estimate, *, blind: bool) -> None:
        """Begin a tick: confine the estimate of the own position by all that is obeyed, and pass it to the
        lines; `blind`: whether the last tick had no odometry."""
        if estimate.shape is not None and self.obeyed:
            self._confine(estimate, estimate.shape)
        position = estimate.position
        self._located = not (estimate.lost or blind)
        if position is None or not self._located:
            self.lines.locate(tick, STILL, inf)  # no constraint is certainly satisfied
        else:
            self.lines.locate(tick, position, estimate.bound, estimate.shape, self._body.swept)

    def _confine(self, estimate: Estimate, shape: Polygon) -> None:
        """Remove the positions from the set that workspace, region and obeyed lines exclude."""
        boundaries = self._boundaries
        for _ in range(CORNERS):
            edges = (each.beyond(estimate.x, estimate.y, shape) for each in boundaries)
            edge = next((each for each in edges if each is not None), None)
            if edge is None or not estimate.confine(edge, "the workspace"):
                break
            shape = estimate.shape or shape
        for peer, side in self.lines.crossed(estimate.x, estimate.y, shape.radius):
            estimate.confine(side, f"the line with robot {peer}" if peer > 0 else f"obstacle {-peer}")

    @property
    def _boundaries(self) -> list[Boundary]:
        region = self.lines.region_disk
        if region is None:
            return [self._workspace]
        return [self._workspace, RoundBoundary(region.radius - self.radius, region.x, region.y)]

    def velocity(self, desired: Vector, estimate: Estimate) -> Vector:
        """The velocity to command, m/s: the nearest to the law's, turned away from what needs room, that
        keeps to all constraints and to the body's limits."""
        if not self.obeyed:
            return desired
        position = estimate.position
        if position is None or not (self._located and self.lines.ready):
            return STILL
        wish, half_planes = self.lines.make_room(desired), self.lines.half_planes()
        return self._body.velocity(wish, Limits(position, half_planes, self._boundaries, estimate.shape))

    def enlarge(self, radius: float, part: int, estimate: Estimate) -> bool:
        """Be a larger disk from now on, of `radius`, m, if that satisfies all that is obeyed and is inside
        the workspace; whether it is. Of disk `part`, unless that is NO, only the present one keeps clear."""
        position = estimate.position
        if position is None or not self._located:
            return False
        swept = 0.0 if self._body.swept is None else self._body.reach
        inside = boundary_of(self._room, radius).contains(*position, estimate.bound + swept)
        if not (inside and self.lines.enlarge(radius, part)):
            return False
        self._resize(radius)
        return True

    def resize(self, radius: float) -> None:
        """Adopt a smaller disk of `radius`, m, or the first one of this life."""
        self.lines.resize(radius)
        self._resize(radius)

    def _resize(self, radius: float) -> None:
        self.radius = radius
        self._workspace = boundary_of(self._room, radius)
