"""Regions of disks, places of static disks, and lines between them: the kernel's geometry.

Rounding never makes two regions disjoint, or one beside a line, if they are not: of the `ROUNDING` by which
robots keep off their half-planes, twice, a line may lose `SURE` at either side.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, final

import numpy as np
from mypy_extensions import mypyc_attr

from protocol.arrays import Reals
from protocol.geometry import Disk, Shape
from protocol.kernel.records import GONE, Held
from protocol.kernel.records import DiskRecord as Disk_
from protocol.line import ROUNDING, SURE, Line


@final
@mypyc_attr(acyclic=True)
class Region:
    """A closed convex set that contains a whole disk. Immutable.

    `obstacle`: whether it is the place of an obstacle: two of these may overlap.
    """

    __slots__ = ("obstacle", "shape")

    def __init__(self, shape: Shape, obstacle: bool = False) -> None:
        self.shape, self.obstacle = shape, obstacle

    @property
    def is_everywhere(self) -> bool:
        """Whether it is the whole plane."""
        return math.isinf(self.shape.around.radius)


EVERYWHERE: Final = Region(Disk(0.0, 0.0, math.inf))


def distance(one: Shape, other: Shape) -> float:
    """Gap between two shapes, at least one of them a disk, m; negative if they overlap."""
    if isinstance(other, Disk):
        if math.isinf(one.around.radius) or math.isinf(other.radius):
            return -math.inf
        return one.distance(other.x, other.y) - other.radius
    if isinstance(one, Disk):
        return distance(other, one)
    return one.around.distance(other.around.x, other.around.y) - other.around.radius


def is_beside(shape: Shape, line: Line, low: bool) -> bool:
    """Whether all of a shape is on one side of a line, up to rounding."""
    if low:
        return shape.support(line.nx, line.ny) <= line.offset + SURE
    return shape.support(-line.nx, -line.ny) <= -line.offset + SURE


def parting(low: Iterable[Shape], high: Iterable[Shape]) -> Line | None:
    """A line in the middle of the gap between two sets of shapes; None if no tried direction has one."""
    ours, theirs = list(low), list(high)
    best, found = 2.0 * SURE, None
    for one in ours:
        for other in theirs:
            nx, ny = _direction(one, other)
            if nx == ny == 0.0:
                continue
            edge = max([each.support(nx, ny) for each in ours])
            gap = -max([each.support(-nx, -ny) for each in theirs]) - edge
            if gap > best:
                best, found = gap, Line(nx, ny, edge + 0.5 * gap)
    return found


def _direction(one: Shape, other: Shape) -> tuple[float, float]:
    """Unit vector from the one to the other; (0, 0) if there is none."""
    (ax, ay, _), (bx, by, _) = _of(one.around), _of(other.around)
    if not isinstance(other, Disk):
        bx, by = other.nearest(ax, ay)
    if not isinstance(one, Disk):
        ax, ay = one.nearest(bx, by)
    dx, dy = bx - ax, by - ay
    length = math.hypot(dx, dy)
    return (0.0, 0.0) if length == 0.0 or math.isinf(length) else (dx / length, dy / length)


def _of(around: Disk) -> tuple[float, float, float]:
    return around.x, around.y, around.radius


def _circle(held: Held[Region]) -> tuple[float, float, float]:
    """A disk around all regions that are held: its centre and radius, m."""
    x, y, radius = _of(held.regions[-1][1].shape.around)
    for _, region in held.regions[:-1]:
        each = region.shape.around
        radius = max(radius, math.hypot(each.x - x, each.y - y) + each.radius)
    return x, y, radius


@final
class RegionGeometry:
    """Implements `protocol.kernel.records.LedgerGeometry`, with a disk around all regions of each disk."""

    def __init__(self) -> None:
        self._names: list[int] = []
        self._rows: dict[int, int] = {}
        self._around: Reals = np.full((3, 16), np.nan)  # x, y, radius, m; NaN if gone

    def note(self, disk: Disk_[Region]) -> None:
        """Note that the regions of a disk, or its presence, have changed."""
        row = self._rows.get(disk.name)
        if row is None:
            row = self._rows[disk.name] = len(self._names)
            self._names.append(disk.name)
            if row == self._around.shape[1]:
                self._around = np.concatenate((self._around, np.full_like(self._around, np.nan)), axis=1)
        self._around[:, row] = math.nan if disk.phase == GONE else _circle(disk.held)

    def around(self, disk: Disk_[Region], region: Region) -> list[int]:
        """Names of all disks, perhaps without some that are gone, or disjoint from this region and the
        disk's.
        """
        circles = _circle(disk.held), _of(region.shape.around)
        less = np.array([(x, y, -radius - ROUNDING) for x, y, radius in circles]).T
        off = self._around[:, None, : len(self._names)] - less[:, :, None]  # x, y, and sum of the radii, m
        square = off * off  # no np.hypot, which takes as long as all else here
        found = (square[0] + square[1] <= square[2]).any(axis=0)
        return [self._names[row] for row in np.flatnonzero(found).tolist()]

    def apart(self, one: Held[Region], other: Held[Region]) -> bool:
        """Whether no region of the one intersects one of the other."""
        for _, region in other.regions:  # noqa: SIM110  # mypyc compiles loops, not generators
            if not self.clear(one, region):
                return False
        return True

    def clear(self, held: Held[Region], region: Region) -> bool:
        """Whether no region that is held intersects this one."""
        for _, each in held.regions:
            both = each.obstacle and region.obstacle
            if not both and not distance(each.shape, region.shape) >= SURE:
                return False
        return True

    def beside(self, held: Held[Region], line: Line, low: bool) -> bool:
        """Whether all regions that are held are on one side of a line."""
        for _, each in held.regions:  # noqa: SIM110
            if not is_beside(each.shape, line, low):
                return False
        return True

    def within(self, place: Region, held: Held[Region]) -> bool:
        """Whether a place is in a region that is held."""
        around = place.shape.around
        for _, each in held.regions:
            outer = each.shape
            if each.is_everywhere:
                return True
            if isinstance(outer, Disk):
                off = math.hypot(around.x - outer.x, around.y - outer.y)
                if off + around.radius <= outer.radius:
                    return True
        return False
