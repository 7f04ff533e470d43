"""What must hold of orders: each asks for one thing, of robots and things that there are at some time."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from protocol.geometry import Disk, Shape
from protocol.scenario.checks.sound import Sound
from protocol.scenario.checks.space import thing_at
from protocol.scenario.shape import Finding, Steps

ACTIONS = ("goal", "add", "remove", "place", "take", "halt")


def named_robots(sound: Sound, ids: Collection[int] | None) -> set[int] | None:
    """Ids that are there at some time, None while one is malformed; `ids` are there at the start."""
    orders = [("orders", index) for index in range(sound.size("orders"))]
    added = [sound.get(*order, "add", "id") for order in orders if sound.get(*order, "add", default="") != ""]
    return None if ids is None or None in added else {*ids, *added}


def order_findings(sound: Sound, room: Shape | None, ids: Collection[int] | None) -> Iterator[Finding]:
    """Everything that is wrong with orders; `room` and `ids` are None while they are malformed."""
    orders: list[Steps] = [("orders", index) for index in range(sound.size("orders"))]
    named = named_robots(sound, ids)
    things = sound.size("things") + sum(_asks(sound, order, "place") for order in orders)
    for order in orders:
        asked = [action for action in ACTIONS if _asks(sound, order, action)]
        if len(asked) != 1:
            yield order, f"must ask for one of {', '.join(ACTIONS)}, {_count(asked)}"
            continue
        yield from _robot(sound, order, named)
        yield from _places(sound, order, room)
        if _asks(sound, order, "place"):
            yield from thing_at(sound, (*order, "place"), room)[1]
        number = sound.get(*order, "take")
        if number is not None and number > things:
            yield (*order, "take"), f"there is never a thing {number}"


def _asks(sound: Sound, order: Steps, action: str) -> bool:
    """Whether an order has this key, malformed or not."""
    return bool(sound.get(*order, action, default="") != "")


def _count(asked: list[str]) -> str:
    return f"not {' and '.join(asked)}" if asked else "and asks for none"


def _robot(sound: Sound, order: Steps, named: Collection[int] | None) -> Iterator[Finding]:
    """Who is sent or removed must be there at some time."""
    for steps in ((*order, "goal", "robot"), (*order, "remove")):
        robot = sound.get(*steps)
        if robot is not None and named is not None and robot not in named:
            yield steps, f"there is never a robot {robot}"


def _places(sound: Sound, order: Steps, room: Shape | None) -> Iterator[Finding]:
    """Points in the workspace, and disks that fit into it."""
    if room is None:
        return
    size, radius = sound.size(*order, "goal", "points"), sound.get(*order, "add", "radius")
    points: list[Steps] = [(*order, "goal", "points", index) for index in range(size)]
    disks: list[Steps] = [(*order, "add", key) for key in ("start", "goal")]
    if isinstance(room, Disk) and radius is not None and radius >= room.radius:
        text = f"a disk of radius {radius:g} m does not fit into the workspace of {room.radius:g} m"
        yield (*order, "add", "radius"), text
        return
    for steps in (*points, *(disks if radius is not None else [])):
        point = sound.get(*steps)
        reach = radius if steps in disks else 0.0
        if point is not None and (beyond := room.distance(*point) + reach) >= 0.0:
            yield steps, f"reaches {beyond:.3g} m out of the workspace" if beyond else "touches the boundary"
