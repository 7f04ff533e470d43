"""Trajectories and recordings as arrays: every stream as columns, for data frames of pandas or polars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, get_args, get_origin

import msgspec
import numpy as np
from numpy.typing import NDArray

from deploy.telemetry.recording import reader
from deploy.telemetry.recording.reader import Truths
from protocol.errors import UsageError
from protocol.keys import STREAMS
from protocol.messages import Vector
from protocol.scenario.model import Scenario

Floats = NDArray[np.float64]


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
    """

    robots: NDArray[np.int64]
    ticks: NDArray[np.int64]
    times: Floats
    positions: Floats
    clearance: Floats
    phi: Floats

    @classmethod
    def of(cls, scenario: Scenario, truths: Truths) -> Trajectory:
        """Arrays of recorded truths, with times from the scenario's tick."""
        times = truths.ticks * scenario.time.step
        return cls(truths.robots, truths.ticks, times, truths.positions, truths.clearance, truths.phi)

    def of_robot(self, robot: int) -> Floats:
        """Positions of one robot, m, shape (n, 2).

        Raises:
            UsageError: the run had no such robot.
        """
        if robot not in self.robots:
            raise UsageError(f"there is no robot {robot}; there are {', '.join(map(str, self.robots))}")
        path: Floats = self.positions[:, int(np.searchsorted(self.robots, robot))]
        return path

    def columns(self) -> dict[str, NDArray[np.generic]]:
        """One row per tick and robot: tick, time (s), robot, x (m), y (m), clearance (m), phi."""
        ticks, robots = self.positions.shape[:2]
        by_tick = {"tick": self.ticks, "time": self.times, "clearance": self.clearance, "phi": self.phi}
        repeated = {name: np.repeat(values, robots) for name, values in by_tick.items()}
        places = {"x": self.positions[..., 0].ravel(), "y": self.positions[..., 1].ravel()}
        found = {**repeated, "robot": np.tile(self.robots, ticks), **places}
        return {name: found[name] for name in ("tick", "time", "robot", "x", "y", "clearance", "phi")}


@dataclass(frozen=True, eq=False)
class Recording:
    """A recorded run.

    Attributes:
        entries: all recorded messages in order, each with `time` (simulated s), `key` and `message`;
            every iteration reads the file again.
        result: as of `disknav.Run`; None if the recording ended before it.
        cut: whether the file is truncated or damaged; the part before the cut is available.
    """

    path: Path
    scenario: Scenario
    result: dict[str, Any] | None
    trajectory: Trajectory
    entries: reader.Entries
    cut: bool

    def columns(self, stream: str) -> dict[str, NDArray[Any]]:
        """One row per message of `stream` ("command", "state", ...), a column for `time` (s) and each field.

        A position or velocity makes two columns, such as `position_x` and `position_y`, NaN where missing;
        other values stay objects. docs/streams.md describes the fields.

        Raises:
            UsageError: no such stream.
        """
        if stream not in STREAMS:
            raise UsageError(f"no stream {stream!r}; there are {', '.join(STREAMS)}")
        entries = list(self.entries.of(STREAMS[stream].message))
        times = np.array([entry.time for entry in entries])
        return {"time": times, **_flat(STREAMS[stream].message, [entry.message for entry in entries])}


def read(path: str | Path) -> Recording:
    """Read a recording of `run` or of the command, complete or truncated.

    Its trajectory has all ticks whose truth was recorded; a busy network may have dropped some.

    Raises:
        UsageError: no such file.
        RecordingError: it is not a recording of a run.
    """
    found = reader.read(path)
    trajectory = Trajectory.of(found.scenario, found.truths)
    return Recording(found.path, found.scenario, found.result, trajectory, found.entries, found.cut)


def _flat(struct: type[msgspec.Struct], values: Sequence[Any], prefix: str = "") -> dict[str, NDArray[Any]]:
    """A column for every field of `struct`; None among `values` is a nested struct that is not there."""
    columns: dict[str, NDArray[Any]] = {}
    for field in msgspec.structs.fields(struct):
        hint, name = _bare(field.type), prefix + field.name
        inner = [None if value is None else getattr(value, field.name) for value in values]
        if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
            columns |= _flat(hint, inner, f"{name}_")
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
