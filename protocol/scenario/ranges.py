"""Ranges of numbers in a scenario file; they are enforced by `protocol.scenario.file`."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Ge, Le

# The bounds of size keep squares and products of lengths away from the ends of a double's range.
# Rounding of coordinates stays a tenth of the nanometre with which lines are kept (docs/safety.md, A8).
FARTHEST = 1e5  # m, of a coordinate
Coordinate = Annotated[float, Ge(-FARTHEST), Le(FARTHEST)]
Length = Annotated[float, Ge(1e-9), Le(FARTHEST)]
Positive = Annotated[float, Ge(1e-9), Le(1e6)]
NonNegative = Annotated[float, Ge(0), Le(1e6)]
Share = Annotated[float, Ge(0), Le(0.9)]
Angle = Annotated[float, Ge(-1e3), Le(1e3)]
HalfTurn = Annotated[float, Ge(0), Le(0.5)]
CELLS = 4.0  # of the grid on which robots plan how to move parts, to the smallest radius
MOST_CELLS = 1e6  # of that grid: some 50 MB of each robot's memory

STRICT = {"extra": "forbid", "allow_inf_nan": False, "alias_generator": lambda name: name.rstrip("_")}
