"""Where robots were, for ROS 2 tools: an MCAP file of the profile `ros2` with `/tf` alone, tick by tick."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from deploy.telemetry.recording.mcap.file import McapFile
from deploy.telemetry.recording.reading.reader import Recording
from deploy.telemetry.recording.writer import LIBRARY
from deploy.telemetry.scene import ros
from deploy.telemetry.scene.drawing import WORLD, frame
from protocol.errors import UsageError


def export(recording: Recording, path: Path) -> None:
    """Write the recorded truths to `path`.

    Raises:
        UsageError: it cannot be written.
    """
    step, truths = recording.scenario.time.step, recording.truths
    frames: dict[tuple[int, ...], ros.Frames] = {}
    try:
        file = McapFile(path, LIBRARY, "ros2")
        number = file.channel("/tf", file.schema(ros.NAME, ros.DEFINITION.encode(), "ros2msg"), {}, "cdr")
        for tick, positions in zip(truths.ticks.tolist(), truths.positions, strict=True):
            time, there = round(tick * step * 1e9), ~np.isnan(positions[:, 0])
            robots = tuple(truths.robots[there].tolist())
            if robots not in frames:
                frames[robots] = ros.Frames(WORLD, [frame(robot) for robot in robots])
            file.message(number, time, frames[robots].message(time, positions[there].tolist()))
        file.finish({})
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}; name a file that can be written") from error
