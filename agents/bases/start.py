"""Whether a robot stands near enough to its start for all to rely on the first lines."""

from __future__ import annotations

import math

from protocol.messages import Vector
from protocol.scenario.model import Scenario

_SHARE = 0.99  # of the room, which leaves more than rounding takes


def misplaced(scenario: Scenario, robot: int, place: Vector, bound: float) -> str:
    """Why a robot at `place`, m, or up to `bound` beside it, cannot begin a run; "" if it can.

    The first line with a peer lies halfway between the two starting disks; to things and to what encloses the
    workspace there is all the room.
    """
    own = scenario.spec(robot)
    room, what = -scenario.workspace.shape.distance(*own.start) - own.radius, "the boundary"
    for other in scenario.robots:
        if other.id != robot:
            gap = math.dist(own.start, other.start) - own.radius - other.radius
            if 0.5 * gap < room:
                room, what = 0.5 * gap, f"robot {other.id}"
    for number, shape in scenario.shapes.items():
        gap = shape.distance(*own.start) - own.radius
        if gap < room:
            room, what = gap, f"thing {number}"
    away = math.dist(place, own.start)
    if away + bound <= _SHARE * room:
        return ""
    x, y = own.start
    return (
        f"stands {away:.3g} m from its start ({x:g}, {y:g}), known to {bound:.2g} m; "
        f"put it within {max(0.0, _SHARE * room - bound):.2g} m, because of {what}"
    )
