"""Small runs, recorded for the tests of recordings and pictures."""

from pathlib import Path
from typing import Any

from deploy.run.local import LocalFleet
from deploy.telemetry.recording.reader import RecordedRun
from protocol.scenario.model import Control, RobotSpec, Scenario, Time

ROBOTS = (
    RobotSpec(1, 0.03, (-0.1, 0.01), (0.1, 0.0)),
    RobotSpec(2, 0.03, (0.1, -0.01), (-0.1, 0.0)),
    RobotSpec(7, 0.03, (0.0, 0.2), (0.0, 0.1)),
)


def scenario(**changes: Any) -> Scenario:
    """Three robots, at most a hundred ticks."""
    return Scenario(
        **({"robots": ROBOTS, "name": "three", "control": Control(k=4.0), "time": Time(limit=5.0)} | changes)
    )


def record(path: Path, **changes: Any) -> dict[str, Any]:
    """Record a run in this process; returns the world's report."""
    with LocalFleet(scenario(**changes), "three", record=path) as fleet:
        return fleet.execute()


def said_by(recording: RecordedRun, kind: type[Any], robot: int) -> list[Any]:
    """What one robot said, or was told, in messages of a kind."""
    return [message for message in recording.said(kind) if message.robot == robot]
