"""Whether a robot has ROS 2 topics, as the scenario configures them, and stands where it may begin."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib.util import find_spec

from protocol.errors import JoinError, UsageError
from protocol.messages import Vector
from protocol.scenario.body import Base
from protocol.scenario.model import Scenario
from protocol.scenario.places import SHARE, room_at_start


def require() -> None:
    """Raise UsageError, with the way to install it, if the library for ROS 2 messages is missing."""
    if find_spec("pycdr2") is None:
        raise UsageError('an external base needs pycdr2, which is not installed: pip install "disknav[ros2]"')


def topics_of(scenario: Scenario, robot: int, namespace: str | None = None) -> Base | None:
    """Names of the topics and frames of a robot; None if it has none.

    Args:
        namespace: of its topics, if it must have a base; if empty, as in the scenario.

    Raises:
        JoinError: it must have a base, and the fleet is simulated.
        UsageError: the library for ROS 2 messages is not installed.
    """
    if namespace is not None and not scenario.is_external:
        raise JoinError(
            f"robot {robot} was given a base, and scenario {scenario.name!r} is simulated: "
            'set world.plant = "external" where the world is started'
        )
    table = scenario.base_of(robot)
    if table is None or not (scenario.is_external or table.tools):
        return None
    require()
    return (replace(table, namespace=namespace) if namespace else table).of(robot)


def misplaced(scenario: Scenario, robot: int, place: Vector, bound: float) -> str:
    """Why a robot at `place`, m, with the error `bound`, cannot begin a run; "" if it can."""
    own = scenario.spec(robot)
    room, what = room_at_start(scenario, robot)
    distance = math.dist(place, own.start)
    if distance + bound <= SHARE * room:
        return ""
    x, y = own.start
    return (
        f"stands {distance:.3g} m from its start ({x:g}, {y:g}), known to {bound:.2g} m; "
        f"put it within {max(0.0, SHARE * room - bound):.2g} m, because of {what}"
    )
