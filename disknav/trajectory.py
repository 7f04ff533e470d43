"""A trajectory as arrays, and as a data frame of pandas or polars."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from deploy.telemetry.recording.reader import Truths
from protocol.errors import UsageError
from protocol.scenario.model import Scenario

if TYPE_CHECKING:
    import pandas
    import polars

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

    def to_pandas(self) -> pandas.DataFrame:
        """`columns` as a pandas data frame; raises ImportError without pandas."""
        import pandas

        return pandas.DataFrame(self.columns())

    def to_polars(self) -> polars.DataFrame:
        """`columns` as a polars data frame; raises ImportError without polars."""
        import polars

        return polars.DataFrame(self.columns())
