"""What must hold of parts: at the start, and at the end, they overlap nothing; and who can carry them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from protocol.geometry import Disk, Shape
from protocol.scenario.checks.bodies import fields_of, robots_of
from protocol.scenario.checks.sound import Sound
from protocol.scenario.checks.space import Placed, shapes_of
from protocol.scenario.ranges import CELLS, MOST_CELLS
from protocol.scenario.shape import Finding

_ENDS = ("start", "goal")


def part_findings(sound: Sound, room: Shape | None, robots: Iterable[Placed]) -> Iterator[Finding]:
    """Parts that nobody in this scenario carries, that are outside, or that overlap a thing, a robot or
    another part where both begin, or end."""
    placed, things = list(robots), list(shapes_of(sound))
    if sound.size("parts"):
        yield from _carriers(sound)
        yield from _cells(sound, room, placed)
    for end in _ENDS:
        others: list[tuple[str, Shape]] = [
            (each.name, each.disk) for each in placed if each.name.startswith(f"the {end} of")
        ]
        others += [(f"things[{number}]", shape) for number, shape in things]
        for index in range(sound.size("parts")):
            centre, radius = sound.get("parts", index, end), sound.get("parts", index, "radius")
            if centre is None or radius is None:
                continue
            disk = Disk(centre[0], centre[1], radius)
            for text in _texts(disk, room, others):
                yield ("parts", index, end), text
            others.append((f"the {end} of part {index + 1}", disk))


def _carriers(sound: Sound) -> Iterator[Finding]:
    """What does not go together with parts."""
    plant = sound.get("world", "plant", default="integrator")
    if plant != "integrator":
        yield ("parts",), f'are carried with world.plant = "integrator" only, not with "{plant}"'
    for robot in robots_of(sound):
        own = sound.get(*robot, "body")
        body = fields_of(sound.get("body") if own is None else own)
        if body.get("kind", "point") != "point":
            yield (*robot, "body"), 'cannot carry parts: leave parts out, or let every body be a "point"'
    if sound.get("network", "interest") == "near":
        yield ("network", "interest"), "robots that carry parts reckon with everybody's way: leave it out"


def _cells(sound: Sound, room: Shape | None, robots: Iterable[Placed]) -> Iterator[Finding]:
    """What makes the grid too large on which each robot plans."""
    found = [sound.get("parts", index, "radius") for index in range(sound.size("parts"))]
    radii = [radius for radius in (*found, *(each.disk.radius for each in robots)) if radius is not None]
    if room is None or not radii:
        return
    (left, low), (right, high) = room.box
    smallest = min(radii)
    cells = (right - left) * (high - low) / (smallest / CELLS) ** 2
    if cells > MOST_CELLS:
        yield (
            ("workspace",),
            f"is too large to carry disks of {smallest:g} m in: to plan on a grid of {CELLS:g} cells to a "
            f"radius takes {cells:.2g} of them, at most {MOST_CELLS:.0e} fit; use larger disks or less room",
        )


def _texts(disk: Disk, room: Shape | None, others: Sequence[tuple[str, Shape]]) -> Iterator[str]:
    if room is not None and (beyond := room.distance(disk.x, disk.y) + disk.radius) > 0.0:
        yield f"reaches {beyond:.3g} m out of the workspace"
    for name, shape in others:
        depth = disk.radius - shape.distance(disk.x, disk.y)
        if depth >= 0.0:
            yield f"overlaps {name} by {depth:.3g} m" if depth else f"touches {name}"
