"""Movers of the disks: formulas or a physics engine; and random disturbances, by robot and tick."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import NamedTuple, Protocol

import msgspec

from protocol.draws import Purpose, Uniforms
from protocol.errors import UsageError
from protocol.messages import Count, Id, Vector
from protocol.scenario.model import RobotSpec, Scenario


class BaseReport(NamedTuple):
    """Odometry and motion of a robot's base at the start of a tick, in the world's frame."""

    displacement: Vector  # m, of the control point in the tick before, by odometry
    way: float  # m, that it went then
    velocity: Vector = (0.0, 0.0)  # m/s, of the control point
    heading: float = 0.0  # rad
    stop: Vector | None = None  # m, from here to its stop without commands; None: it stands


class PastDisks(msgspec.Struct, frozen=True):
    """The disks at the end of a world, at the end of a tick, by robot id."""

    places: dict[Id, Vector] = {}  # of the centres of present robots, m
    headings: dict[Id, float] = {}  # rad; empty for bodies without heading
    ways: dict[Id, float] = {}  # path lengths of present and past robots, m; of all with one id together
    bounds: dict[Id, float] = {}  # errors of places until all bases stand, m, where there are any
    moving: tuple[Id, ...] = ()  # external robots that may still move
    largest_bound: float | None = None  # of all reports so far, m; None if the truth is known
    parts: Count = 1  # straight motions per tick, which a run keeps when its last body with inertia has left

    def moved(self, scenario: Scenario) -> Scenario:
        """The scenario with these places as starts."""
        robots = [
            replace(spec, start=self.places[spec.id], heading=self.headings.get(spec.id, spec.heading))
            for spec in scenario.robots
        ]
        return replace(scenario, robots=tuple(robots))


class Plant(Protocol):
    """Every robot's disk and its base."""

    ids: tuple[int, ...]  # of robots, in increasing order, that of all lists below
    positions: list[Vector]  # true positions of the disks' centres, m
    lengths: list[float]  # path length of each so far, m
    parts: int  # straight motions per tick, the chords of arcs: at most 0.03 mm off with the presets' wheels
    between: list[tuple[Vector, ...]]  # positions at the ends of all parts of the last tick but the last
    slips: bool  # whether odometry is inexact by itself; otherwise the stated errors are added to it
    fixed: str  # the reason why robots cannot be added or removed; "" if they can

    def refusal(self, spec: RobotSpec) -> str:
        """The reason why this robot cannot be added; "" if it can."""
        ...

    def set_fleet(self, scenario: Scenario) -> None:
        """Set the robots, unless the plant is `fixed`: new ones start, removed ones are forgotten."""

    def move(self, commands: Mapping[int, Vector], tick: int) -> None:
        """Advance a tick with commanded velocities (m/s) by robot id; others receive none."""

    def report(self, index: int) -> BaseReport:
        """The report of the base at that index of `ids`."""
        ...

    def stands(self, index: int) -> bool:
        """Whether the base at that index of `ids` stands until it receives another command."""
        ...

    def touched(self) -> Sequence[tuple[int, int]]:
        """Pairs of ids whose disks touched in the last tick, if the plant itself can tell."""
        ...


def require(plant: str) -> None:
    """Raise UsageError if a plant's library is not installed, without loading it."""
    if plant == "mujoco" and find_spec("mujoco") is None:
        raise UsageError(
            'world.plant = "mujoco" needs MuJoCo, which is not installed: pip install "disknav[mujoco]"'
        )


def plant_of(scenario: Scenario, parts: int = 1) -> Plant:
    """The plant of `scenario.world.plant`, of at least so many parts per tick; raises UsageError if its
    library is not installed."""
    require(scenario.world.plant)
    if scenario.world.plant == "mujoco":
        from world.plants.mujoco import Physics  # the engine is loaded only if used

        return Physics(scenario)
    from world.plants.integrator import Integrator  # it imports this module

    return Integrator(scenario, parts)


_INSIDE = 1.0 - 1e-9  # keeps rounding in later sums from carrying a disturbance past its bound


def truncated_normal(radial: float, angular: float, deviation: float, bound: float) -> Vector:
    """An isotropic normal vector, conditioned on its length being at most `bound`.

    The length of an isotropic normal vector is Rayleigh distributed and independent of its angle,
    so two uniform numbers in [0, 1) give the truncated one by inversion.

    Args:
        radial, angular: uniform draws in [0, 1).
        deviation: standard deviation per axis before truncation, >= 0.
        bound: largest length, in the unit of `deviation`.
    """
    if deviation <= 0.0 or bound <= 0.0:
        return (0.0, 0.0)
    ratio = bound / deviation
    length = deviation * math.sqrt(-2.0 * math.log1p(radial * math.expm1(-0.5 * ratio * ratio)))
    length = min(length, bound * _INSIDE)
    angle = 2.0 * math.pi * angular
    return (length * math.cos(angle), length * math.sin(angle))


class UnitDisk:
    """Random vectors of one robot, evenly distributed in a disk whose radius is a little less than one."""

    def __init__(self, seed: int, purpose: Purpose, robot: int) -> None:
        self._draws = Uniforms(seed, purpose, robot, 2)

    def at(self, tick: int) -> Vector:
        """The vector of one tick."""
        size, direction = self._draws.at(tick)
        length, angle = math.sqrt(size) * _INSIDE, 2.0 * math.pi * direction
        return length * math.cos(angle), length * math.sin(angle)
