"""A recording played again: verified, published on a bus, or exported for ROS 2 tools."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.writer import Writer

from deploy.output.target import writing
from deploy.telemetry.recording.reader import Recording
from deploy.telemetry.recording.trajectory import Trajectory, trajectory
from deploy.telemetry.recording.writer import LIBRARY
from deploy.telemetry.scene import ros
from deploy.telemetry.scene.drawing import WORLD, frame
from protocol.bus.bus import Bus, Publish
from protocol.codec import encode
from protocol.errors import RecordingError
from protocol.keys import parse, robot_key, world_key
from protocol.messages import Result
from protocol.process.signals import STOP
from protocol.streams import STREAMS


class Published(NamedTuple):
    """What was published: simulated time, s, key and payload as on the network."""

    time: float
    key: str
    payload: bytes


def published(recording: Recording, run: str | None = None) -> Iterator[Published]:
    """All that was published, in order, under the keys of `run` (the recorded name unless given)."""
    run = run or recording.run
    last = 0.0
    for last, recorded_key, message in recording.entries:
        address = parse(recorded_key)
        name, robot = address.stream, address.robot
        key = world_key(run, name) if robot is None else robot_key(run, robot, name)
        yield Published(last, key, encode(message))
    if recording.result is not None:
        yield Published(last, world_key(run, "result"), encode(Result(json.dumps(recording.result))))


def verify(recording: Recording) -> Trajectory | None:
    """The recomputed trajectory; None when the recording has no result to compare it with, or no beginning.

    Raises:
        RecordingError: it is not the result's, or it cannot be recomputed.
    """
    if recording.result is None or recording.preceding:
        return None
    found, said = trajectory(recording), recording.result.get("trajectory_sha256")
    if found.sha256 != said:
        raise RecordingError(
            f"{recording.path}: the recorded trajectory has hash {found.sha256}, its result says {said}: "
            f"the file was changed, or recorded from another run; record the run again"
        )
    return found


def publish(
    recording: Recording,
    bus: Bus,
    run: str | None = None,
    *,
    speed: float = 1.0,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Publish a recording on a network, `speed` simulated seconds a second (0: as fast as possible)."""
    publishers: dict[str, Publish] = {}
    began = time.monotonic()
    duration = float(recording.truths.ticks[-1]) * recording.scenario.time.step
    for now, key, payload in published(recording, run):
        if key not in publishers:
            publishers[key] = bus.publisher(STREAMS[parse(key).stream], key)
        if speed > 0.0:
            STOP.wait(max(0.0, began + now / speed - time.monotonic()))
        STOP.check()
        publishers[key](payload)
        if progress is not None:
            progress(min(1.0, now / duration) if duration > 0.0 else 1.0)


def export(recording: Recording, path: Path) -> None:
    """Write the recorded truths to `path`.

    Raises:
        UsageError: it cannot be written.
    """
    step, truths = recording.scenario.time.step, recording.truths
    frames: dict[tuple[int, ...], ros.Frames] = {}
    with writing(path, "write ROS 2 messages"), path.open("wb") as file:
        writer: Any = Writer(file)  # partly untyped
        writer.start("ros2", LIBRARY)
        schema = writer.register_schema(ros.NAME, "ros2msg", ros.DEFINITION.encode())
        channel = writer.register_channel("/tf", "cdr", schema)
        for tick, positions in zip(truths.ticks.tolist(), truths.positions, strict=True):
            time, there = round(tick * step * 1e9), ~np.isnan(positions[:, 0])
            robots = tuple(truths.robots[there].tolist())
            if robots not in frames:
                frames[robots] = ros.Frames(WORLD, [frame(robot) for robot in robots])
            data = frames[robots].message(time, positions[there].tolist())
            writer.add_message(channel, time, data, time)
        writer.finish()
