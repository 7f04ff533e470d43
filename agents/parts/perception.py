"""Parts and peers in one tick, their precedence, and how a robot makes way.

A robot that carries a part precedes one that fetches one, which precedes one that does neither; among equals
the lower id precedes. Precedence does not depend on positions, since two robots that exchanged it in motion
would block each other. None of this is needed for safety, which the separating lines ensure.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from agents.parts.grid import Cells, Grid, Layout
from agents.peers.neighbours import Neighbours, radii_of
from agents.peers.state import PeerState
from protocol.arrays import Reals
from protocol.geometry import Disk, Shape
from protocol.messages import Claim, Member, Vector
from protocol.scenario.model import Scenario

ASIDE: Final = 0.2  # clearance from the paths of preceding robots, own radii
AHEAD: Final = 0.5  # look-ahead for blocking another robot's path, own radii
_KEPT: Final = 16  # cached distance fields


@dataclass(frozen=True)
class Traveller:
    """A robot on the way."""

    at: Vector  # its position, m
    to: Vector  # its goal, m
    radius: float  # of its disk, m
    among: tuple[Shape, ...]  # obstacles on its way
    leaves: tuple[Shape, ...] = ()  # obstacles that it leaves at its goal: the part that it puts down


class Traffic:
    """Paths among obstacles, for one robot."""

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._fields: dict[tuple[Vector, float, tuple[Shape, ...]], tuple[Cells, Reals]] = {}

    def aim(self, me: Traveller, first: Sequence[Traveller]) -> Vector:
        """The next waypoint, m: along the own path, off the paths of robots that precede (`first`)."""
        ways = [self._way(each) for each in first]
        aim = self._ahead(me)
        if self._is_in_the_way(me.at, me, first, ways):
            return self._aside(me, first, ways) or aim
        distance = math.dist(me.at, aim)
        part = min(1.0, AHEAD * me.radius / max(distance, 1e-9))
        soon = me.at[0] + part * (aim[0] - me.at[0]), me.at[1] + part * (aim[1] - me.at[1])
        return me.at if self._is_in_the_way(soon, me, first, ways) else aim

    def _ahead(self, me: Traveller) -> Vector:
        """The farthest point of the own path that is in a straight line of sight."""
        free, _ = self._field(me)
        path = self._way(me)
        if len(path) < 2 or self._grid.sees(free, me.at, me.to):
            return me.to
        seen = [point for point in path[1:-1] if self._grid.sees(free, me.at, point)]
        return seen[-1] if seen else path[min(2, len(path) - 1)]

    def _way(self, traveller: Traveller) -> list[Vector]:
        return self._grid.path(self._field(traveller)[1], traveller.at)

    def _field(self, traveller: Traveller) -> tuple[Cells, Reals]:
        """Free cells of a robot, and the distance field of its goal, m."""
        key = traveller.to, traveller.radius, traveller.among
        if key not in self._fields:
            if len(self._fields) >= _KEPT:
                del self._fields[next(iter(self._fields))]
            free = self._grid.clear(traveller.among, traveller.radius)
            self._fields[key] = free, self._grid.distance_field(free, [traveller.to])
        return self._fields[key]

    def _aside(
        self, me: Traveller, first: Sequence[Traveller], ways: Sequence[Sequence[Vector]]
    ) -> Vector | None:
        """A waypoint off the paths of others, m, not enclosed by the parts that they put down if possible;
        None if there is none."""
        free = self._grid.clear(me.among, me.radius)
        wanted = free.copy()
        for each, way in zip(first, ways, strict=True):
            distances = self._distances([each.at, *way, each.to])
            wanted &= distances >= self._room(me, each)
            free &= self._distances([each.at]) >= me.radius + each.radius
        far = self._grid.distance_field(free, [me.at])
        far[~wanted] = np.inf
        open_ = np.where(self._stays_open(me, first), far, np.inf)
        far = open_ if np.isfinite(open_).any() else far
        best = np.unravel_index(int(far.argmin()), far.shape)
        if not math.isfinite(far[best]):
            return None
        goal = float(self._grid.x[best]), float(self._grid.y[best])
        back = self._grid.path(self._grid.distance_field(free, [goal]), me.at)
        seen = [point for point in back if self._grid.sees(free, me.at, point)]
        return seen[-1] if seen else goal

    def _stays_open(self, me: Traveller, first: Sequence[Traveller]) -> Cells:
        """Cells with a path to the robot's goal after the others have put their parts down."""
        left = [shape for each in first for shape in each.leaves]
        return np.isfinite(
            self._grid.distance_field(self._grid.clear((*me.among, *left), me.radius), [me.to])
        )

    def _is_in_the_way(
        self, at: Vector, me: Traveller, first: Sequence[Traveller], ways: Sequence[Sequence[Vector]]
    ) -> bool:
        return any(
            min(math.dist(at, point) for point in [each.at, *way]) < self._room(me, each)
            for each, way in zip(first, ways, strict=True)
        )

    def _room(self, me: Traveller, other: Traveller) -> float:
        return me.radius + other.radius + ASIDE * me.radius

    def _distances(self, way: Sequence[Vector]) -> Reals:
        far = np.full(self._grid.x.shape, np.inf)
        for x, y in way:
            np.minimum(far, np.hypot(self._grid.x - x, self._grid.y - y), out=far)
        return far


class Perception:
    """Parts and peers in one tick."""

    def __init__(self, scenario: Scenario, neighbours: Neighbours) -> None:
        self._scenario = scenario
        stand = neighbours.standing
        carried = {each.carrier: each.part for each in neighbours.parts if each.carrier}
        self.peers = neighbours.moving()  # States of live peers
        self.claims = self._claims()  # robot and claim of each live peer that claims a part of the scenario
        # By live robot, the part that it carries; by part on the floor, the number of its obstacle.
        self.carriers = {robot: part for robot, part in carried.items() if robot not in stand}
        self.obstacles = {each.part: each.obstacle for each in neighbours.parts if not each.carrier}
        shapes = {part: neighbours.numbered.get(number) for part, number in self.obstacles.items()}
        at = {part: (disk.x, disk.y) for part, disk in shapes.items() if isinstance(disk, Disk)}
        robots = {robot: self._empty(each, carried) for robot, each in stand.items()}
        self._under = {part: robots[robot] for robot, part in carried.items() if robot in stand}
        at |= {part: (disk.x, disk.y) for part, disk in self._under.items()}
        parts = {each.obstacle for each in neighbours.parts}
        others = [shape for number, shape in sorted(neighbours.numbered.items()) if number not in parts]
        self.layout = Layout(
            at,
            (*others, *robots.values()),
            {part: stand[robot].radius for robot, part in carried.items() if robot in stand},
            self._promised([state.robot for state in self.peers]),
            tuple(state.position for state in self.peers if state.position is not None),
        )

    def heeding(self, robots: Collection[int]) -> Perception:
        """The perception with the claims and carried parts of these robots only."""
        found = copy(self)
        found.claims = [(robot, claim) for robot, claim in self.claims if robot in robots]
        found.layout = replace(self.layout, promised=found._promised(robots))
        return found

    def _claims(self) -> list[tuple[int, Claim]]:
        parts = range(1, len(self._scenario.parts) + 1)
        return [(peer.robot, peer.claim) for peer in self.peers if peer.claim and peer.claim.part in parts]

    def among(self, part: int) -> tuple[Shape, ...]:
        """Shapes of the layout without one part, and without the static robot that it is on, if any."""
        parts = self._scenario.parts
        disks = [
            Disk(*at, self.layout.held.get(each, parts[each - 1].radius))
            for each, at in self.layout.parts.items()
            if each != part
        ]
        under = self._under.get(part)
        return (*(each for each in self.layout.others if each is not under), *disks)

    def _promised(self, robots: Collection[int]) -> dict[int, Vector]:
        """Targets of the parts that these robots claim or carry, m."""
        parts = {claim.part for _, claim in self.claims}
        parts |= {part for robot, part in self.carriers.items() if robot in robots}
        return {part: self._scenario.parts[part - 1].goal for part in parts}

    def _empty(self, member: Member, carried: dict[int, int]) -> Disk:
        """The disk of a static robot without its part."""
        assert member.position is not None
        own = radii_of(self._scenario.robots).get(member.robot, member.radius)
        radius = own if member.robot in carried else member.radius
        return Disk(*member.position, radius + member.bound)

    def first(self, robot: int, claim: Claim | None) -> list[PeerState]:
        """Peers that precede a robot with this claim."""
        mine = self._rank(robot, claim)
        return [peer for peer in self.peers if self._rank(peer.robot, peer.claim) < mine]

    def _rank(self, robot: int, claim: Claim | None) -> tuple[int, int]:
        if robot in self.carriers:
            return 0, robot
        return 2 if claim is None else 1, robot

    def traveller(self, peer: PeerState) -> Traveller | None:
        """A peer on its way; None if its position is unknown."""
        at, parts = peer.position, self._scenario.parts
        if at is None:
            return None
        claim = dict(self.claims).get(peer.robot)
        if claim is None:
            home = next((each.goal for each in self._scenario.robots if each.id == peer.robot), at)
            return Traveller(at, home, peer.radius, self.among(0))
        part = claim.part
        spec, carries = parts[part - 1], self.carriers.get(peer.robot) == part
        to = spec.goal if carries else self.layout.parts.get(part, at)
        leaves = (Disk(*spec.goal, spec.radius),) if carries else ()
        return Traveller(at, to, peer.radius, self.among(part), leaves)
