"""Recordings as arrays: the trajectory, and every stream as columns."""

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
from disknav.trajectory import Trajectory
from protocol.errors import UsageError
from protocol.keys import STREAMS
from protocol.messages import Vector
from protocol.scenario.model import Scenario


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
