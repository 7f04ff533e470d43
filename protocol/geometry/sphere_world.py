"""Sphere worlds: a disk-shaped room with disks in it that do not touch each other, nor its boundary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from protocol.geometry.disk import Disk
from protocol.geometry.polygon import ConvexPolygon

Shape = Disk | ConvexPolygon
ROOM = 0  # stands for the boundary where things are numbered


def obstructed(room: Shape, shapes: Mapping[int, Shape], radius: float) -> Iterator[tuple[int, int]]:
    """Pairs of things, or of boundary (`ROOM`) and thing, that a disk of `radius` (m) does not pass between.

    Of what is no disk, the disk around it counts.
    """
    disks = {number: shape.around for number, shape in shapes.items()}
    for (one, a), (other, b) in combinations(disks.items(), 2):
        if a.distance(b.x, b.y) - b.radius <= 2.0 * radius:
            yield one, other
    for number, disk in disks.items():
        if -room.distance(disk.x, disk.y) - disk.radius <= 2.0 * radius:
            yield ROOM, number


def is_sphere_world(room: Shape, shapes: Mapping[int, Shape], radius: float) -> bool:
    """Whether the centre of a disk of `radius` (m) moves in a sphere world."""
    round_ = all(isinstance(shape, Disk) for shape in (room, *shapes.values()))
    return round_ and next(obstructed(room, shapes, radius), None) is None
