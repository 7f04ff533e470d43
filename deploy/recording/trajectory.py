"""The trajectory of a recording, whole even where a truth was dropped on its way to the recorder.

Truths are for whoever watches, and the network may drop them. Ticks it may not, and each says what
its robot really did during the tick before: added to where the disk was, that is where it was next, to the
last bit.
"""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

from deploy.recording.reader import Recording
from protocol.errors import RecordingError
from protocol.messages import Vector
from world.judge.trajectory import TrajectoryDigest

_Plane = list[Vector]


class Trajectory(NamedTuple):
    """Its SHA-256 as in the result, and how many of its ticks had to be worked out from odometry."""

    sha256: str
    restored: int

    @property
    def remark(self) -> str:
        """What has to be said of it; empty if every tick was recorded."""
        return f" ({self.restored} ticks worked out from odometry)" if self.restored else ""


def trajectory(recording: Recording) -> Trajectory:
    """Recompute the trajectory up to the last tick known.

    Raises:
        RecordingError: a tick is missing that cannot be worked out either.
    """
    known = _known(recording)
    ticks = range(max(known) + 1)
    moves = _Moves(recording) if len(known) < len(ticks) else None
    path: list[_Plane] = []
    for tick in ticks:
        path.append(moves.follow(path[-1], tick) if moves and tick not in known else known[tick])
    digest = TrajectoryDigest(recording.scenario.ids)
    digest.add(ticks, path)
    return Trajectory(digest.hexdigest(), len(ticks) - len(known))


def _known(recording: Recording) -> dict[int, _Plane]:
    """Positions by tick; those of the last are in the result, too."""
    truths, result = recording.truths, recording.result or {}
    known = {
        tick: [(x, y) for x, y in positions]
        for tick, positions in zip(truths.ticks.tolist(), truths.positions.tolist(), strict=True)
    }
    final = result.get("positions", {})
    if final and "ticks" in result:
        known.setdefault(result["ticks"], [tuple(final[str(robot)]) for robot in recording.scenario.ids])
    return known


class _Moves:
    """What each robot did during a tick, by the tick that followed."""

    def __init__(self, recording: Recording) -> None:
        self._path, self._ids = recording.path, recording.scenario.ids
        self._said: defaultdict[int, dict[int, Vector]] = defaultdict(dict)
        self._commanded: set[tuple[int, int]] = set()
        for robot, told in recording.told.items():
            for tick in told:
                if tick.sense is not None:
                    self._said[tick.tick][robot] = tick.sense.displacement
        for robot, commands in recording.commands.items():
            self._commanded.update((robot, command.tick) for command in commands)

    def follow(self, before: _Plane, tick: int) -> _Plane:
        """Where all are at the start of `tick`; whoever is told nothing and commanded nothing stood still."""
        after = []
        for robot, (x, y) in zip(self._ids, before, strict=True):
            move = self._said[tick].get(robot)
            if move is None and (robot, tick - 1) in self._commanded:
                raise RecordingError(
                    f"{self._path}: the truth of tick {tick} was not recorded, nor what robot {robot} did "
                    f"before it, so the trajectory cannot be checked; record on a machine with less load"
                )
            dx, dy = move or (0.0, 0.0)
            after.append((x + dx, y + dy))
        return after
