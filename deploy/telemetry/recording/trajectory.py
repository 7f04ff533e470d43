"""Trajectories as arrays, and messages as columns, for data frames of pandas or polars."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, get_args, get_origin

import msgspec
import numpy as np
from numpy.typing import NDArray

from protocol.arrays import Reals
from protocol.errors import UsageError
from protocol.messages import Truth, Vector


class CompactTruth(NamedTuple):
    """A `Truth` with its numbers in one array: clearance, phi, log_potential, x, y, x, y, ..."""

    tick: int
    robots: tuple[int, ...]
    numbers: Reals

    @classmethod
    def of(cls, truth: Truth) -> CompactTruth:
        places = chain.from_iterable(truth.positions)
        return cls(
            truth.tick, truth.robots, np.array([truth.clearance, truth.phi, truth.log_potential, *places])
        )


@dataclass(frozen=True, eq=False)
class Trajectory:
    """True position of every disk at the start of every tick.

    Attributes:
        robots: ids of all robots of the run, ascending, shape (p,).
        ticks: shape (n,); a recording may lack some.
        times: s, shape (n,).
        positions: m, shape (n, p, 2), robots in the order of `robots`; NaN where a robot was absent.
        clearance: m, shape (n,), smallest gap between two disks, or a disk and the boundary or an obstacle,
            during the tick before, over continuous time; negative is overlap.
        phi: shape (n,), the navigation function, 0 at the goal.
        log_potential: shape (n,), log10(gamma / beta^(1/k)).
    """

    robots: NDArray[np.int64]
    ticks: NDArray[np.int64]
    times: Reals
    positions: Reals
    clearance: Reals
    phi: Reals
    log_potential: Reals

    @classmethod
    def of(cls, truths: Iterable[CompactTruth], step: float) -> Trajectory:
        """From truths in the order of ticks, with a period of `step` s."""
        rows = list(truths)
        robots = np.array(sorted(set(chain.from_iterable({row.robots for row in rows}))), dtype=np.int64)
        positions = np.full((len(rows), len(robots), 2), np.nan)
        for places, row in zip(positions, rows, strict=True):
            places[np.searchsorted(robots, row.robots)] = row.numbers[3:].reshape(-1, 2)
        measured = np.array([row.numbers[:3] for row in rows]).reshape(-1, 3).T
        ticks = np.array([row.tick for row in rows])
        return cls(robots, ticks, ticks * step, positions, *measured)

    def at(self, rows: NDArray[np.bool_]) -> Trajectory:
        """The part at some ticks, of the robots that are present then."""
        there = ~np.isnan(self.positions[rows, :, 0]).all(axis=0)
        measured = (each[rows] for each in (self.clearance, self.phi, self.log_potential))
        positions = self.positions[rows][:, there]
        return Trajectory(self.robots[there], self.ticks[rows], self.times[rows], positions, *measured)

    @property
    def missing(self) -> int:
        """Number of ticks missing from tick 0 to the last known one."""
        return int(self.ticks[-1]) + 1 - len(self.ticks) if len(self.ticks) else 0

    def of_robot(self, robot: int) -> Reals:
        """Positions of one robot, m, shape (n, 2).

        Raises:
            UsageError: the run had no such robot.
        """
        if robot not in self.robots:
            raise UsageError(f"there is no robot {robot}; there are {', '.join(map(str, self.robots))}")
        path: Reals = self.positions[:, int(np.searchsorted(self.robots, robot))]
        return path

    def columns(self) -> dict[str, NDArray[np.generic]]:
        """One row per tick and robot: tick, time (s), robot, x (m), y (m), clearance (m), phi."""
        ticks, robots = self.positions.shape[:2]
        by_tick = {"tick": self.ticks, "time": self.times, "clearance": self.clearance, "phi": self.phi}
        repeated = {name: np.repeat(values, robots) for name, values in by_tick.items()}
        places = {"x": self.positions[..., 0].ravel(), "y": self.positions[..., 1].ravel()}
        found = {**repeated, "robot": np.tile(self.robots, ticks), **places}
        return {name: found[name] for name in ("tick", "time", "robot", "x", "y", "clearance", "phi")}


def columns_of(
    struct: type[msgspec.Struct], values: Sequence[Any], prefix: str = ""
) -> dict[str, NDArray[Any]]:
    """A column for every field of `struct`; None among `values` is a nested struct that is not there."""
    columns: dict[str, NDArray[Any]] = {}
    for field in msgspec.structs.fields(struct):
        hint, name = _bare(field.type), prefix + field.name
        inner = [None if value is None else getattr(value, field.name) for value in values]
        if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
            columns |= columns_of(hint, inner, f"{name}_")
        elif hint == Vector:
            plane = np.array([(np.nan, np.nan) if each is None else each for each in inner]).reshape(-1, 2)
            columns |= {f"{name}_x": plane[:, 0], f"{name}_y": plane[:, 1]}
        elif hint is float or (hint in (int, bool, str) and None not in inner):
            columns[name] = np.array(inner, dtype=hint)
        else:
            columns[name] = np.empty(len(inner), dtype=object)
            columns[name][:] = inner
    return columns


def _bare(hint: Any) -> Any:
    """A field's type without bounds, and without None where that is the only alternative."""
    if get_origin(hint) is Annotated:
        return _bare(get_args(hint)[0])
    if get_origin(hint) is UnionType:
        others = [each for each in get_args(hint) if each is not NoneType]
        return _bare(others[0]) if len(others) == 1 else hint
    return hint
