"""The report of `disknav check` on robots among obstacles, or in a polygonal workspace.

For the centre of a disk, obstacles are inflated by its radius. Start and goal lie in different parts of free
space exactly if a closed chain of overlapping inflated obstacles, the outside of the workspace among them,
runs between the two: inflated obstacles are convex, so chains represent every closed curve in their union,
and a plane set separates two points exactly if a closed curve in it does (Alexander duality): if it crosses
the straight way from one to the other an odd number of times.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

from rich.console import Group, RenderableType
from rich.text import Text
from scipy.cluster.hierarchy import DisjointSet

from agents.law.obstacles import Attraction
from agents.law.passages import OUTSIDE, Gap, crosses
from agents.law.passages import gaps as passages
from agents.parts.grid import Layout
from agents.parts.planner import Planner
from deploy.theory.facts import Facts
from deploy.theory.tuning import Door, doors
from protocol.geometry import ROOM, Disk, Shape, obstructed
from protocol.messages import Vector
from protocol.scenario.model import Scenario

Theorem = Literal["Karagoz-Bozma-Koditschek", "Koditschek-Rimon"]


def theorem_for(scenario: Scenario) -> tuple[Theorem | None, tuple[str, ...]]:
    """The theorem that covers a scenario; if there is none, the reasons.

    - Robots alone in a disk: Karagöz, Bozma and Koditschek, Theorem 1.
    - One robot in a disk among disks so far from each other and the boundary that it can pass between them: a
      sphere world (Koditschek and Rimon, "Robot navigation functions on manifolds with boundary", 1990).
    """
    reasons = []
    if not isinstance(scenario.workspace.shape, Disk):
        reasons.append("the workspace is a polygon, not a disk")
    shapes = scenario.shapes
    polygons = [number for number, shape in shapes.items() if not isinstance(shape, Disk)]
    if polygons:
        count = len(polygons)
        reasons.append(f"{count} obstacles are not round" if count > 1 else "1 obstacle is not round")
    if scenario.parts:
        reasons.append("no theorem covers carried parts")
    if shapes and len(scenario.robots) > 1:
        reasons.append("no theorem covers several robots among static obstacles")
    if shapes and not reasons:
        reasons += _not_apart(scenario)
    if reasons:
        return None, tuple(reasons)
    return ("Koditschek-Rimon" if shapes else "Karagoz-Bozma-Koditschek"), ()


def _not_apart(scenario: Scenario) -> Iterator[str]:
    pairs = obstructed(scenario.workspace.shape, scenario.shapes, scenario.robots[0].radius)
    for one, other in pairs:
        between = f"obstacle {other} and the boundary" if one == ROOM else f"obstacles {one} and {other}"
        yield f"the robot cannot pass between {between}"


_KBK = "Karagöz, Bozma and Koditschek's Theorem 1"
_SAYS: dict[Theorem | None, str] = {
    "Koditschek-Rimon": (
        "A sphere world: for every k above some bound phi is a navigation function (Koditschek, Rimon 1990), "
        "so almost every start leads to the goal. The bound is not evaluated here."
    ),
    None: "Arrival is not proven for any k.",
}
_LAW = {
    True: "In a sphere world the attraction is straight, as in the theorem.",
    False: "The law follows the shortest way around the obstacles; arrival is tested, not proven.",
}
_ORDER = {
    True: "Parts can reach their goals one after another; arrival is tested, not proven.",
    False: "No order of the parts leads all to their goals: some must be moved out of the way first.",
}


def separating(obstacles: Sequence[Shape], closed: Sequence[Gap], start: Vector, goal: Vector) -> Gap | None:
    """The gap that, after those before it, closes the last path from start to goal; None if a path remains.

    Args:
        obstacles: as indexed by the gaps.
        closed: gaps that are too narrow, in the order in which they close.
        start, goal: places that keep clear of all obstacles, m.
    """
    outside = len(obstacles)
    halves = DisjointSet(range(2 * outside + 2))  # of each obstacle; a crossing joins unlike ones
    inside = [shape.nearest(0.0, 0.0) for shape in obstacles]  # a point of each
    for gap in closed:
        chain = [inside[gap.one], gap.begin, gap.end]
        chain += [inside[gap.other]] if gap.other != OUTSIDE else []
        crossed = sum(crosses(a, b, start, goal) for a, b in pairwise(chain))
        other = outside if gap.other == OUTSIDE else gap.other
        for half in (0, 1):
            halves.merge(2 * gap.one + half, 2 * other + (half + crossed) % 2)
        if halves.connected(2 * gap.one, 2 * gap.one + 1):
            return gap
    return None


class BlockedPath(NamedTuple):
    """Obstacles that separate a robot's goal from its start, without the other robots and all parts."""

    robot: int
    width: float  # m, of the widest of all paths at its narrowest point
    x: float  # m, of that point
    y: float


def barriers(scenario: Scenario) -> list[BlockedPath]:
    """Robots whose goals no controller can reach among these obstacles; an exact decision."""
    room, obstacles = scenario.workspace.shape, [obstacle.shape for obstacle in scenario.obstacles]
    found = []
    near = passages(room, obstacles, 2.0 * max(spec.radius for spec in scenario.robots))
    for spec in scenario.robots:
        closed = [gap for gap in near if gap.width < 2.0 * spec.radius]
        gap = separating(obstacles, closed, spec.start, spec.goal)
        if gap is not None:
            found.append(BlockedPath(spec.id, gap.width, *_middle(gap.begin, gap.end)))
    return found


def _middle(a: Vector, b: Vector) -> Vector:
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])


@dataclass(frozen=True)
class Surrounded:
    """Results of `disknav check` among obstacles. Lengths in m."""

    facts: Facts
    obstacles: int
    theorem: Theorem | None  # the one that covers the scenario, if any; `reasons` otherwise
    reasons: tuple[str, ...]
    unreachable: tuple[BlockedPath, ...]  # goals that no controller can reach, even without other robots
    no_way: tuple[int, ...]  # robots for which the law finds no path, although one exists
    doors: tuple[Door, ...]  # passages that need a larger k for a robot
    parts: int = 0
    order: bool | None = None  # whether parts can reach their goals one after another; None without parts

    def render(self) -> RenderableType:
        """Tables and sentences for the terminal."""
        carried = f" and {self.parts} parts" if self.parts else ""
        table = self.facts.table(f" among {self.obstacles} obstacles{carried}, together")
        says = [
            *([f"{_KBK} does not apply: {'; '.join(self.reasons)}."] if self.reasons else []),
            _SAYS[self.theorem],
            _LAW[self.theorem is not None] if self.order is None else _ORDER[self.order],
            "Collision avoidance is independent of these results (docs/safety.md).",
            *(_blocked(each) for each in self.unreachable),
            *(
                f"NO PATH FOUND for robot {robot}, although one exists: its attraction is straight."
                for robot in self.no_way
            ),
            *(_held(each, self.facts) for each in self.doors),
        ]
        return Group(table, Text(), *(Text(line) for line in says))


def surrounded(scenario: Scenario) -> Surrounded:
    """Report on a valid scenario whose k is a number."""
    theorem, reasons = theorem_for(scenario)
    unreachable = barriers(scenario)
    return Surrounded(
        facts=Facts.of(scenario),
        obstacles=len(scenario.obstacles),
        theorem=theorem,
        reasons=reasons,
        unreachable=tuple(unreachable),
        no_way=tuple(_without_way(scenario, {each.robot for each in unreachable})),
        doors=tuple(doors(scenario, scenario.k)),
        parts=len(scenario.parts),
        order=_has_order(scenario) if scenario.parts else None,
    )


def _has_order(scenario: Scenario) -> bool:
    layout = Layout(
        {number: part.start for number, part in enumerate(scenario.parts, 1)},
        tuple(obstacle.shape for obstacle in scenario.obstacles),
    )
    starts = [each.start for each in scenario.robots]
    radii = {each.radius for each in scenario.robots}
    return any(Planner(scenario, radius).orders.exists(layout, starts) for radius in radii)


def _without_way(scenario: Scenario, unreachable: set[int]) -> list[int]:
    """Robots whose attraction leads straight into obstacles."""
    room, shapes = scenario.workspace.shape, list(scenario.shapes.values())
    specs = [scenario.spec(robot) for robot in scenario.ids if robot not in unreachable]
    pulls = {spec.radius: Attraction(room, spec.radius, alone=len(scenario.robots) == 1) for spec in specs}
    return [spec.id for spec in specs if not pulls[spec.radius].leads(spec.start, spec.goal, shapes)]


def _blocked(found: BlockedPath) -> str:
    return (
        f"UNREACHABLE: obstacles block every path of robot {found.robot}; the widest is {found.width:.4g} m "
        f"wide at ({found.x:.4g}, {found.y:.4g})."
    )


def _held(door: Door, facts: Facts) -> str:
    x, y = _middle(door.gap.begin, door.gap.end)
    return (
        f"TOO NARROW FOR k = {facts.k:.4g}: robot {door.robot} may stop before the passage of "
        f"{door.gap.width:.4g} m at ({x:.4g}, {y:.4g}); it needs k > {door.gain:.4g} "
        f"(auto gives {facts.automatic_k:.4g})."
    )
