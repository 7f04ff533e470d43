"""What moves the disks: formulas, or a physics engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import NamedTuple, Protocol

import msgspec

from protocol.errors import UsageError
from protocol.messages import Id, Vector
from protocol.scenario.model import RobotSpec, Scenario


class Report(NamedTuple):
    """What a robot's base says of itself at the start of a tick, in the world's frame."""

    displacement: Vector  # m, of the control point in the tick before, by odometry
    way: float  # m, that it went then
    velocity: Vector = (0.0, 0.0)  # m/s, of the control point
    heading: float = 0.0  # rad
    stop: Vector | None = None  # m, from here to where it stands if it hears nothing more; None: it stands


class PastDisks(msgspec.Struct, frozen=True):
    """Where a world leaves the disks, at the end of a tick.

    Attributes:
        ids: of the robots that are there, ascending; the next three lists are in this order.
        positions: of their centres, m.
        headings: rad; empty where no body has one.
        lengths: path length of each, in this world, m.
        before: path lengths of robots in earlier worlds, and of those that left, m.
        bounds: by how much places may be off until all bases stand, m, where they may.
        moving: robots outside that may not stand yet.
        largest_bound: of all reports so far, m; None where the truth is known.
    """

    ids: tuple[Id, ...]
    positions: list[Vector]
    headings: list[float]
    lengths: list[float]
    before: dict[Id, float]
    bounds: dict[Id, float] = {}
    moving: tuple[Id, ...] = ()
    largest_bound: float | None = None

    def moved(self, scenario: Scenario) -> Scenario:
        """The scenario with these places as starts."""
        places = dict(zip(self.ids, self.positions, strict=True))
        headings = dict(zip(self.ids, self.headings, strict=False))
        robots = [
            replace(spec, start=places[spec.id], heading=headings.get(spec.id, spec.heading))
            for spec in scenario.robots
        ]
        return replace(scenario, robots=tuple(robots))

    @property
    def ways(self) -> dict[int, float]:
        """Path length of every robot that is or was there, m; of all that had the same id together."""
        ways = dict(self.before)
        for robot, length in zip(self.ids, self.lengths, strict=True):
            ways[robot] = ways.get(robot, 0.0) + length
        return ways


class Plant(Protocol):
    """Every robot's disk and what carries it.

    Attributes:
        ids: robot ids in increasing order; all lists below are in this order.
        positions: where the disks' centres really are, m.
        lengths: path length of each so far, m.
        parts: straight motions that a tick consists of, up to some micrometres that an arc is off its chord.
        between: where the disks were at the ends of all parts of the last tick but the last one.
        fixed: why robots can neither come nor go; "" if they can.
        slips: whether odometry is inexact by itself; else errors up to the stated ones are to be added to it.
    """

    ids: tuple[int, ...]
    positions: list[Vector]
    lengths: list[float]
    parts: int
    between: list[tuple[Vector, ...]]
    slips: bool
    fixed: str

    def refusal(self, spec: RobotSpec) -> str:
        """Why this robot cannot be added; "" if it can."""
        ...

    def set_fleet(self, scenario: Scenario) -> None:
        """Robots came and went, where the plant is not `fixed`: a new one is at its start; of one that left
        nothing is kept."""

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """Go through a tick with commanded velocities (m/s) by robot id; others hear nothing."""

    def report(self, index: int) -> Report:
        """What the base at that place of `ids` says of itself."""
        ...

    def stands(self, index: int) -> bool:
        """Whether the base at that place of `ids` does not move until it hears another command."""
        ...

    def touched(self) -> Sequence[tuple[int, int]]:
        """Pairs of ids whose disks touched in the last tick, if the plant itself can tell."""
        ...


def require(plant: str) -> None:
    """Find out whether a plant's library is there, without loading it.

    Raises:
        UsageError: it is not installed; says how to.
    """
    if plant == "mujoco" and find_spec("mujoco") is None:
        raise UsageError(
            'world.plant = "mujoco" needs MuJoCo, which is not installed: pip install "disknav[mujoco]"'
        )


def plant_of(scenario: Scenario) -> Plant:
    """The plant of `scenario.world.plant`.

    Raises:
        UsageError: its library is not installed.
    """
    require(scenario.world.plant)
    if scenario.world.plant == "mujoco":
        from world.plants.mujoco import Physics  # the engine is loaded only where it is asked for

        return Physics(scenario)
    from world.plants.integrator import Integrator  # it imports this module

    return Integrator(scenario)
