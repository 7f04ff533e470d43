"""What stands on the layout, and where a robot stands to take a part up from there or to put it down."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

import numpy as np

from agents.parts.grid import Grid, depth, distance_to
from protocol.geometry import Disk, Shape
from protocol.messages import Vector
from protocol.scenario.model import Part, Scenario

_Kept = TypeVar("_Kept")

DIRECTIONS: Final = 64  # from which a part is tried
GAPS: Final = (0.5, 0.15, 0.85)  # of the reach, between a robot and a part
MARGIN: Final = 0.1  # of the reach, by which places keep clear of all else
_HOME: Final = 1e-9  # m


@dataclass(frozen=True)
class Layout:
    """What stands; two are the same if that is.

    Attributes:
        parts: where each stands, m; one on a robot whose life is over stands where that robot does.
        others: things that are no parts, and robots whose lives are over, as disks that carry nothing.
        held: of parts on such robots, the radius of the disk that both are, m.
        promised: where parts are to stand that robots have in hand or claim, m.
        robots: where robots are that live, without the one that looks, m.
    """

    parts: Mapping[int, Vector]
    others: tuple[Shape, ...] = ()
    held: Mapping[int, float] = field(default_factory=dict)
    promised: Mapping[int, Vector] = field(default_factory=dict, compare=False)
    robots: tuple[Vector, ...] = field(default=(), compare=False)

    @property
    def settled(self) -> Layout:
        """What stands once everybody has done what it is about to do."""
        return replace(self, parts={**self.parts, **self.promised}, held=_without(self.held, *self.promised))

    def moved(self, part: int, to: Vector) -> Layout:
        """The same with a part elsewhere, m."""
        return replace(self, parts={**self.parts, part: to}, held=_without(self.held, part))

    def without(self, part: int) -> Layout:
        """The same once a part was taken up."""
        return replace(self, parts=_without(self.parts, part), held=_without(self.held, part))


class Places:
    """Places for robots of one radius.

    Args:
        scenario: with the radii of robots that carry nothing.
        radius: of a robot that carries nothing, m.
        grid: of the room.
    """

    def __init__(self, scenario: Scenario, radius: float, grid: Grid) -> None:
        self.parts: dict[int, Part] = dict(enumerate(scenario.parts, 1))
        self.radius, self.reach = radius, scenario.carrying.reach
        self._room, self._grid = scenario.workspace.shape, grid
        turns = np.arange(DIRECTIONS) * (math.tau / DIRECTIONS)
        self._cos, self._sin = np.cos(turns), np.sin(turns)

    def loaded(self, part: int) -> float:
        """Radius of the disk that a robot is with a part, m."""
        return max(self.radius, self.parts[part].radius)

    def size(self, part: int, layout: Layout) -> float:
        """Radius of the disk that a part is where it stands, m."""
        return layout.held.get(part, self.parts[part].radius)

    def standing(self, layout: Layout) -> list[Shape]:
        """All that stands."""
        disks = [Disk(*at, self.size(part, layout)) for part, at in layout.parts.items()]
        return [*layout.others, *disks]

    def is_home(self, part: int, layout: Layout) -> bool:
        """Whether a part stands at its goal."""
        at = layout.parts.get(part)
        return at is not None and part not in layout.held and math.dist(at, self.parts[part].goal) < _HOME

    def is_barred(self, part: int, layout: Layout) -> bool:
        """Whether something stands at a part's goal for good."""
        spec = self.parts[part]
        return any(shape.distance(*spec.goal) < spec.radius for shape in layout.others)

    def to_take(self, part: int, layout: Layout) -> list[Vector]:
        """Where a robot can take a part up, and be the disk that it is with it, m.

        On a robot that stands the part remains until it is asked for by a disk that is clear of both.
        """
        grown = self.loaded(part) - self.radius if part in layout.held else 0.0
        rest = self.standing(layout.without(part))
        return self._around(
            layout.parts[part], self.radius + self.size(part, layout), grown, self.loaded(part), rest
        )

    def to_put(self, part: int, target: Vector, layout: Layout) -> list[Vector]:
        """Where a robot that has a part can put it down at a target, m; nowhere if something stands there."""
        radius, loaded, rest = self.parts[part].radius, self.loaded(part), self.standing(layout)
        if any(shape.distance(*target) < radius for shape in rest):
            return []
        return self._around(target, loaded + radius, 0.0, loaded, rest)

    def _around(
        self, centre: Vector, touching: float, least: float, radius: float, rest: list[Shape]
    ) -> list[Vector]:
        """Places at a gap between `least` and the reach at which a disk of `radius` is clear of the rest."""
        spread = self.reach - least
        if spread <= 0.0:
            return []
        gaps = np.array([touching + least + part * spread for part in GAPS])
        x = (centre[0] + np.outer(gaps, self._cos)).ravel()
        y = (centre[1] + np.outer(gaps, self._sin)).ravel()
        room = radius + MARGIN * self.reach
        clear = depth(self._room, x, y) >= room
        near = float(gaps.max()) + room
        for shape in rest:
            if shape.distance(*centre) < near:
                clear &= distance_to(shape, x, y) >= room
        return [(float(x[n]), float(y[n])) for n in clear.nonzero()[0]]


def _without(kept: Mapping[int, _Kept], *parts: int) -> dict[int, _Kept]:
    return {each: what for each, what in kept.items() if each not in parts}
