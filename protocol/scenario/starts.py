"""How near to its start a robot outside has to stand as a run begins."""

from __future__ import annotations

import math
from typing import Final

from protocol.scenario.model import Scenario

SHARE: Final = 0.99  # of the room, which leaves more than rounding takes


def room_at_start(scenario: Scenario, robot: int) -> tuple[float, str]:
    """How far a robot may be from its start, m, and because of what.

    Half of the gap to another starting disk is the other's; to obstacles and to what encloses the workspace
    there is all the room.
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
    return room, what
