"""What one robot obeys: separating lines with peers, tangents to things, and the boundary of the workspace.

Whatever a law asks for, what is commanded is the nearest velocity that keeps to all of them, or none at all
while one is missing. They say where the robot cannot be, too, which narrows its estimate down.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf
from typing import Final, final

from agents.bodies import Body, Limits
from agents.estimate import Estimate
from agents.lines.boundary import boundary_of
from agents.lines.polygon import Polygon
from agents.lines.separating_lines import SeparatingLines
from agents.lines.things import Things
from agents.peers.fleet import fleet_of
from protocol.crowd.interest import urgent
from protocol.messages import Member, Thing, Vector
from protocol.scenario.model import Scenario

STILL: Vector = (0.0, 0.0)
CORNERS: Final = 4  # that the workspace cuts off the own set in a tick, at most


@final
class SafetyFilter:
    """All that one incarnation of one robot keeps to; with `filter = "none"` it is known, but not obeyed.

    Args:
        scenario: the run.
        robot: own id.
        incarnation: own incarnation.
        radii: of every robot, m, own included.
        body: what carries the robot.
        members: of the first roster that this incarnation hears, by id.
        founding: whether it began the run: if so, disks were where the scenario lets them begin.

    Attributes:
        radius: of the own disk, m.
        lines: with peers.
        things: that stand.
        obeyed: whether the scenario has its robots keep to all this.
    """

    def __init__(
        self,
        scenario: Scenario,
        robot: int,
        incarnation: int,
        radii: Mapping[int, float],
        body: Body,
        members: Mapping[int, Member],
        founding: bool,
    ) -> None:
        speed = scenario.control.speed * (1.0 + scenario.actuation.bound)
        starts = fleet_of(scenario.robots).starts
        self.obeyed = scenario.control.filter == "separating-lines"
        self.radius = radii[robot]
        self.things = Things(
            self.radius,
            scenario.shapes,
            starts[robot] if founding else None,
            speed=speed,
            period=scenario.time.step,
            reach=body.reach,
        )
        self.lines = SeparatingLines(
            robot,
            incarnation,
            radii,
            speed=speed,
            period=scenario.time.step,
            reach=body.reach,
            berth=body.standoff,
            members=members,
            starts=starts if founding else None,
            urgent=urgent(scenario) if scenario.hears_near else None,
        )
        self._body, self._room = body, scenario.workspace.shape
        self._boundary = boundary_of(self._room, self.radius)
        self._located = False  # whether it is surely known where the robot is

    def on_roster(self, news: Iterable[Member], things: Sequence[Thing]) -> None:
        """A newer roster.

        Args:
            news: what it says anew of others.
            things: that came or went, all of them.
        """
        for member in news:
            self.lines.on_member(member)
        self.things.follow(things)

    def locate(self, tick: int, estimate: Estimate, *, blind: bool) -> None:
        """A tick begins; the robot is where the estimate says, and on the own side of all that it obeys.

        Args:
            tick: that begins.
            estimate: of the own position, which is narrowed down.
            blind: whether nothing is known of how far the robot went in the last tick.
        """
        if estimate.shape is not None and self.obeyed:
            self._confine(estimate, estimate.shape)
        position = estimate.position
        self._located = position is not None and not estimate.lost and not blind
        if position is None or not self._located:
            self.lines.locate(tick, position or STILL, inf)  # nothing is surely satisfied
            self.things.locate(position or STILL, inf)
        else:
            known = (position, estimate.bound, estimate.shape, self._body.swept)
            self.lines.locate(tick, *known)
            self.things.locate(*known)

    def _confine(self, estimate: Estimate, shape: Polygon) -> None:
        """Cut off from the set of possible positions what workspace, obeyed lines and things exclude."""
        for _ in range(CORNERS):
            edge = self._boundary.beyond(estimate.x, estimate.y, shape)
            if edge is None or not estimate.confine(edge, "the workspace"):
                break
            shape = estimate.shape or shape
        for peer, side in self.lines.crossed(estimate.x, estimate.y, shape):
            estimate.confine(side, f"the line with robot {peer}")
        for number, side in self.things.crossed(estimate.x, estimate.y, estimate.shape or shape):
            estimate.confine(side, f"thing {number}")

    @property
    def ready(self) -> bool:
        """Whether there is something between this robot and everything that is there."""
        return self.lines.ready and self.things.ready

    @property
    def keeps_clear(self) -> bool:
        """Whether the own disk is and stays clear of every place where a disk or a thing is to appear."""
        return not self.obeyed or (self.lines.keeps_clear and self.things.keeps_clear)

    def velocity(self, desired: Vector, estimate: Estimate) -> Vector:
        """The velocity to command, m/s: the nearest to the desired one, turned away from what needs room,
        that keeps to everything and to the body's limits.

        Args:
            desired: by the law, m/s.
            estimate: of the own position, which is known.
        """
        if not self.obeyed:
            return desired
        position = estimate.position
        if position is None or not (self._located and self.ready):
            return STILL
        wish = self.things.make_room(self.lines.make_room(desired))
        half_planes = [*self.lines.half_planes(), *self.things.half_planes()]
        return self._body.velocity(wish, Limits(position, half_planes, self._boundary, estimate.shape))

    def has_room(self, radius: float, held: int, estimate: Estimate) -> bool:
        """Whether a larger disk would satisfy all that is obeyed.

        Args:
            radius: of it, m.
            held: a thing that only the present disk keeps clear of; 0 for none.
            estimate: of the own position.
        """
        position = estimate.position
        if position is None or not (self._located and self.ready):
            return False
        swept = 0.0 if self._body.swept is None else self._body.reach
        inside = boundary_of(self._room, radius).contains(*position, estimate.bound + swept)
        return inside and self.lines.has_room(radius) and self.things.has_room(radius, held)

    def resize(self, radius: float, held: int) -> None:
        """The own disk is one of `radius` from now on, m; a larger one only where it `has_room`."""
        self.things.resize(radius, held)
        if radius != self.radius:
            self.radius = radius
            self._boundary = boundary_of(self._room, radius)
            self.lines.resize(radius)
