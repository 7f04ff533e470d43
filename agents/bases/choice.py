"""Which base a scenario gives a robot."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec

from agents.bases.base import Base
from protocol.errors import JoinError, UsageError
from protocol.scenario.model import Scenario


def require() -> None:
    """Find out whether the library that reads and writes ROS 2 messages is there, without loading it.

    Raises:
        UsageError: it is not installed; says how to.
    """
    if find_spec("pycdr2") is None:
        raise UsageError('a base outside needs pycdr2, which is not installed: pip install "disknav[ros2]"')


def base_of(scenario: Scenario, robot: int, namespace: str | None = None) -> Base | None:
    """What moves a robot; None if it is simulated.

    Args:
        scenario: the run.
        robot: its id.
        namespace: of its topics, if it must have a base; empty, as the scenario has it.

    Raises:
        JoinError: it must have a base, and the fleet is simulated.
        UsageError: what reads ROS 2 messages is not installed.
    """
    table = scenario.base_of(robot) if scenario.is_external else None
    if table is not None:
        require()
        from agents.bases.ros2 import Ros2Base  # only a robot that is not simulated needs it

        return Ros2Base(scenario, robot, replace(table, namespace=namespace) if namespace else table)
    if namespace is not None:
        raise JoinError(
            f"robot {robot} was given a base, and scenario {scenario.name!r} is simulated: "
            'set world.plant = "external" where the world is started'
        )
    return None
