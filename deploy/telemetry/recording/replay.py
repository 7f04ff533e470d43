"""Replaying a recording: its trajectory recomputed, published on a bus, or exported for ROS 2 tools."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence, Set
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.writer import Writer

from deploy.output import writing
from deploy.telemetry.recording.reader import Progress, Recording
from deploy.telemetry.recording.writer import LIBRARY
from deploy.telemetry.scene import WORLD, frame
from protocol.arrays import Reals
from protocol.bus.bus import Bus, Publish, Sample
from protocol.codec import encode
from protocol.errors import RecordingError
from protocol.keys import STREAMS, parse, robot_key, world_key
from protocol.messages import Command, Result, Tick, Vector
from protocol.process.installation import missing_library
from protocol.process.signals import STOP
from world.judge.record import trajectory_rows


class Participant(NamedTuple):
    """A robot that was present for some time."""

    robot: int  # its id
    radius: float  # m
    goal: Vector | None  # m, from the scenario; None for a robot that an operator added
    path: np.ndarray  # m, shape (n, 2), by recorded tick; NaN while its disk was absent

    @property
    def known(self) -> np.ndarray:
        """Part of the path while it was present."""
        known: np.ndarray = self.path[~np.isnan(self.path[:, 0])]
        return known


def participants(recording: Recording) -> list[Participant]:
    """All robots of the recording, by id."""
    scenario, known = recording.scenario, recording.trajectory
    specs = {spec.id: spec for spec in (*scenario.newcomers, *scenario.robots)}
    robots: list[int] = known.robots.tolist()
    radii = _announced(recording, set(robots).difference(specs))
    return [
        Participant(
            robot,
            specs[robot].radius if robot in specs else radii.get(robot, 0.0),
            specs[robot].goal if robot in specs else None,
            known.positions[:, index],
        )
        for index, robot in enumerate(robots)
    ]


def _announced(recording: Recording, robots: set[int]) -> dict[int, float]:
    """Radii of robots that operators added, m, from recorded rosters."""
    radii: dict[int, float] = {}
    for tick in recording.messages(Tick) if robots else ():
        members = () if tick.roster is None else tick.roster.members
        radii.update({each.robot: each.radius for each in members if each.robot in robots})
        if len(radii) == len(robots):
            break
    return radii


class _Plane(NamedTuple):
    """Positions of all present disks, m."""

    robots: tuple[int, ...]
    places: Sequence[Vector] | Reals


class CheckedTrajectory(NamedTuple):
    """SHA-256 of the trajectory as in the result, and the number of ticks reconstructed from odometry."""

    sha256: str
    restored: int

    @property
    def remark(self) -> str:
        """Remark on reconstructed ticks; empty if there are none."""
        return f" ({self.restored} ticks reconstructed from odometry)" if self.restored else ""


def recomputed(recording: Recording) -> CheckedTrajectory:
    """Recompute the trajectory's digest up to the last known tick, as the result has it: from the first tick
    of the run, or of the last of several worlds.
    Raises RecordingError if a missing tick cannot be reconstructed: the first one, one without odometry, or
    one in which robots appeared or left.
    """
    if recording.preceding:
        raise RecordingError(
            f"{recording.path} continues {recording.preceding}: name the first file of the recording"
        )
    known = _known(recording)
    begin = max((recording.result or {}).get("worlds", ()), default=0)
    if begin not in known:
        first = f"the Truth of tick {begin}, the first of the trajectory, was not recorded"
        raise _unchecked(recording, first)
    if max(known) - begin > recording.counts.total():
        raise _unchecked(recording, "most of its ticks were not recorded")
    missing = set(range(begin, max(known))).difference(known)
    moves = _Moves(recording, missing) if missing else None
    digest = hashlib.sha256()
    here = _Plane((), [])
    for tick in range(begin, max(known) + 1):
        there = moves.follow(here, tick) if moves and tick in missing else known[tick]
        if there.robots != here.robots and tick - 1 in missing:
            changed = f"robots appeared or left before tick {tick}"
            raise _unchecked(recording, f"{changed}, and the Truth of the previous tick was not recorded")
        digest.update(trajectory_rows(there.robots, [tick], np.array([there.places])))
        here = there
    return CheckedTrajectory(digest.hexdigest(), len(missing))


def _unchecked(recording: Recording, why: str) -> RecordingError:
    so = "so the trajectory cannot be checked; record with less load on the machine"
    return RecordingError(f"{recording.path}: {why}, {so}")


def _known(recording: Recording) -> dict[int, _Plane]:
    recorded, result = recording.trajectory, recording.result or {}
    known: dict[int, _Plane] = {}
    for tick, positions in zip(recorded.ticks.tolist(), recorded.positions, strict=True):
        there = ~np.isnan(positions[:, 0])
        known[tick] = _Plane(tuple(recorded.robots[there].tolist()), positions[there])
    final = {int(robot): tuple(place) for robot, place in (result.get("positions") or {}).items()}
    if final and "ticks" in result:
        robots = tuple(sorted(final))
        known.setdefault(result["ticks"], _Plane(robots, [final[robot] for robot in robots]))
    return known


class _Moves:
    """Motion of each robot in the tick before each of `ticks`, from odometry."""

    def __init__(self, recording: Recording, ticks: Set[int]) -> None:
        self._recording = recording
        self._sensed: defaultdict[int, dict[int, Vector]] = defaultdict(dict)
        self._commanded: dict[tuple[int, int], Vector] = {}
        for _, _, message in recording.entries.of(Tick, Command):
            if isinstance(message, Command) and message.tick + 1 in ticks:
                self._commanded[message.robot, message.tick] = message.velocity
            elif isinstance(message, Tick) and message.tick in ticks and message.sense is not None:
                self._sensed[message.tick][message.robot] = message.sense.displacement

    def follow(self, before: _Plane, tick: int) -> _Plane:
        """Positions at the start of `tick`; a robot without Tick and Command did not move."""
        after = []
        for robot, (x, y) in zip(before.robots, before.places, strict=True):
            move, velocity = self._sensed[tick].get(robot), self._commanded.get((robot, tick - 1))
            if move is None and velocity is not None:
                lost = f"the Truth of tick {tick} was not recorded, nor the odometry of robot {robot}"
                raise _unchecked(self._recording, lost)
            dx, dy = move or (0.0, 0.0)
            after.append((x + dx, y + dy))
        return _Plane(before.robots, after)


def published(recording: Recording, run: str | None = None) -> Iterator[tuple[float, Sample]]:
    """All published messages in order, each with its simulated time (s), under the keys of `run` (default:
    the recorded name).
    """
    run = run or recording.run
    last = 0.0
    for last, recorded_key, message in recording.entries:
        _, robot, name, _ = parse(recorded_key)
        key = world_key(run, name) if robot is None else robot_key(run, robot, name)
        yield last, Sample(key, encode(message))
    if recording.result is not None:
        yield last, Sample(world_key(run, "result"), encode(Result(json.dumps(recording.result))))


def verify(recording: Recording) -> CheckedTrajectory | None:
    """The recomputed trajectory; None if the recording has no beginning, or no hash in a result.
    Raises RecordingError if it differs from the result's, or cannot be recomputed.
    """
    recorded = (recording.result or {}).get("trajectory_sha256")  # None: of a world that was lost
    if recorded is None or recording.preceding:
        return None
    found = recomputed(recording)
    if found.sha256 != recorded:
        raise RecordingError(
            f"{recording.path}: the recorded trajectory has hash {found.sha256}, its result says {recorded}: "
            f"the file was changed, or recorded from another run; record the run again"
        )
    return found


def publish(
    recording: Recording,
    bus: Bus,
    run: str | None = None,
    *,
    speed: float = 1.0,
    progress: Progress = lambda _: None,
) -> None:
    """Publish a recording on a bus, `speed` simulated seconds per second (0: as fast as possible)."""
    publishers: dict[str, Publish] = {}
    began = time.monotonic()
    duration = float(recording.trajectory.times[-1])
    for now, sample in published(recording, run):
        key, payload = sample.key, sample.payload
        if key not in publishers:
            publishers[key] = bus.publisher(STREAMS[parse(key).stream], key)
        if speed > 0.0:
            STOP.wait(max(0.0, began + now / speed - time.monotonic()))
        STOP.check()
        publishers[key](payload)
        progress(min(1.0, now / duration) if duration > 0.0 else 1.0)


_TF = "tf2_msgs/msg/TFMessage"


def export(recording: Recording, path: Path) -> None:
    """Write the recorded Truths to `path` as ROS 2 transforms.
    Raises UsageError if it cannot be written, or pycdr2 is not installed.
    """
    try:
        from agents.bases.ros_messages import Transform, Transforms, header_at
    except ModuleNotFoundError as error:
        raise missing_library("writing ROS 2 messages", "pycdr2", "ros2") from error
    recorded = recording.trajectory
    with writing(path, "write ROS 2 messages"), path.open("wb") as file:
        writer: Any = Writer(file)  # partly untyped
        writer.start("ros2", LIBRARY)
        definition = (Path(__file__).parent / "TFMessage.msg").read_bytes()
        channel = writer.register_channel("/tf", "cdr", writer.register_schema(_TF, "ros2msg", definition))
        for seconds, positions in zip(recorded.times.tolist(), recorded.positions, strict=True):
            time = round(seconds * 1e9)
            header = header_at(time, WORLD)
            poses = [
                Transform(header, frame(robot), [x, y, 0.0], [0.0, 0.0, 0.0, 1.0])
                for robot, (x, y) in zip(recorded.robots.tolist(), positions.tolist(), strict=True)
                if not math.isnan(x)
            ]
            writer.add_message(channel, time, Transforms(poses).serialize(), time)
        writer.finish()
