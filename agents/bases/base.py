"""What a robot needs of whatever moves it, if it is not simulated; and which base a scenario gives it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from importlib.util import find_spec
from typing import Protocol

from protocol.errors import JoinError, UsageError
from protocol.messages import Command, Sense, Tick, Vector
from protocol.scenario.model import Scenario
from protocol.scenario.places import SHARE, room_at_start


class Base(Protocol):
    """A base and a localisation outside. Sans-I/O: it is told what arrives, and says what is to be sent.

    Attributes:
        keys: under which it wants to hear.
        tells: the key under which it sends.
        due: when `wake` wants to be called, s.
    """

    keys: tuple[str, ...]
    tells: str
    due: float

    @property
    def note(self) -> str:
        """Why nothing can be relied on, so that the robot stands; "" if all is well."""
        ...

    def hear(self, key: str, payload: bytes, now: float) -> Vector | None:
        """Something arrived under one of `keys`; the wish for a law from outside that it is, m/s, or None.

        Raises:
            MessageError: it is no wish that can be read.
        """

    def place(self) -> tuple[Vector, float] | None:
        """Where the robot is, m, and by how much that may be off, m; None if that is not known."""
        ...

    def begin(self, tick: Tick, now: float) -> Sense | None:
        """A tick begins: what is known of the robot; None if nothing can be relied on."""
        ...

    def begins_anew(self) -> bool:
        """Whether all is well after it was not, so that what was known before is void; says so once."""
        ...

    def obey(self, command: Command, now: float) -> None:
        """Carry out the Command of the tick that began last; to be called before it is sent."""

    def doubt(self, why: str) -> None:
        """The robot found out that what it was told cannot be true: rely on nothing so far."""

    def stand(self, now: float) -> None:
        """Brake: no tick goes on."""

    def wake(self, now: float) -> Iterable[bytes]:
        """What is to be sent under `tells` by now."""
        ...


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


def misplaced(scenario: Scenario, robot: int, place: Vector, bound: float) -> str:
    """Why a robot at `place`, m, or up to `bound` beside it, cannot begin a run; "" if it can."""
    own = scenario.spec(robot)
    room, what = room_at_start(scenario, robot)
    away = math.dist(place, own.start)
    if away + bound <= SHARE * room:
        return ""
    x, y = own.start
    return (
        f"stands {away:.3g} m from its start ({x:g}, {y:g}), known to {bound:.2g} m; "
        f"put it within {max(0.0, SHARE * room - bound):.2g} m, because of {what}"
    )
