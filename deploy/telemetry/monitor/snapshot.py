"""What viewers are told: the view as plain data, from any thread."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from deploy.telemetry.monitor.live import ALARMS, FleetView, RobotView
from protocol.geometry import Disk, Shape
from protocol.messages import PlacedObstacle, Truth
from protocol.operations import Outcome, Steer
from protocol.scenario.model import Operation

_SAMPLES = 8  # of the past that a snapshot carries, at most


def overview(view: FleetView) -> dict[str, Any]:
    """What does not change during a run, and its past: for a viewer that has just arrived."""
    told: dict[str, Any] = {"kind": "overview", "epoch": view.epoch, "run": view.run, "scenario": None}
    if view.scenario is not None:
        scenario = view.scenario
        told |= {
            "scenario": scenario.name,
            "description": scenario.description,
            "room": _outline(scenario.workspace.shape),
            "box": scenario.workspace.shape.box,
            "obstacles": {str(number): _outline(shape) for number, shape in scenario.shapes.items()},
            "step": scenario.time.step,
            "limit": scenario.time.limit,
            "speed": scenario.control.speed,
            "lockstep": view.lockstep,
            "robots": [_still(robot) for robot in view.robots.values()],
            "history": view.history.items,
            "tick": view.recent[-1].tick if view.recent else -1,
        }
    return told


def _outline(shape: Shape) -> dict[str, Any]:
    """A disk or a polygon, as a scenario file has it."""
    if isinstance(shape, Disk):
        return {"center": (shape.x, shape.y), "radius": shape.radius}
    return {"points": shape.points}


def _change(obstacle: PlacedObstacle) -> dict[str, Any] | None:
    """An obstacle that came, or None for one that went."""
    return None if obstacle.status == "gone" else _outline(obstacle.shape) | {"status": obstacle.status}


def _still(robot: RobotView) -> dict[str, Any]:
    spec = robot.spec
    trail = [[round(x, 5), round(y, 5)] for x, y in robot.trail.items]
    goal = robot.errand.goal
    return {"id": spec.id, "radius": spec.radius, "start": spec.start, "goal": goal, "trail": trail}


def snapshot(view: FleetView, now: float, since: int = -1) -> dict[str, Any]:
    """The present, with a few samples of what happened after tick `since`."""
    newest = max((robot.tick for robot in view.robots.values()), default=0)
    step = view.scenario.time.step if view.scenario else 0.0
    return {
        "kind": "frame",
        "epoch": view.epoch,
        "run": view.run,
        "phase": view.phase,
        "tick": view.tick,
        "time": round(view.tick * step, 6),
        "pace": view.ticks_per_second(now),
        "verdict": view.verdict,
        "reason": view.reason,
        "steering": {"paused": view.steering.paused, "speed": view.steering.speed},
        "smallest": view.smallest,
        "robots": [_row(view, robot, now, newest) for robot in view.robots.values()],
        "samples": _samples(view, since),
        "obstacles": {str(obstacle.number): _change(obstacle) for obstacle in view.obstacles},
    }


def _row(view: FleetView, robot: RobotView, now: float, newest: int) -> dict[str, Any]:
    assert view.scenario is not None
    status = robot.status(now, newest, view.scenario.time.tolerance, ended=bool(view.verdict))
    return robot.row(now, newest) | {"status": status, "alarm": status in ALARMS}


def _samples(view: FleetView, since: int) -> list[list[Any]]:
    """At most `_SAMPLES` of the truths after `since`, each with the smallest clearance up to it."""
    fresh = [truth for truth in view.recent if truth.tick > since]
    stride = -(-len(fresh) // _SAMPLES) or 1
    return [_sample(view, fresh[n : n + stride]) for n in range(0, len(fresh), stride)]


def _sample(view: FleetView, group: list[Truth]) -> list[Any]:
    assert view.scenario is not None
    last = group[-1]
    where = dict(zip(last.robots, last.positions, strict=False))
    places = [
        [round(part, 6) for part in where.get(robot, known.position)] for robot, known in view.robots.items()
    ]
    clearance = min(truth.clearance for truth in group)
    return [last.tick, round(last.tick * view.scenario.time.step, 6), clearance, last.log_potential, places]


class Source:
    """A view with a lock: one thread writes, others look. They never wait for each other's network.

    Every method may be called from any thread.
    """

    def __init__(self, run: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._view = FleetView(run)
        self._lock = threading.Lock()
        self._clock = clock

    def overview(self) -> dict[str, Any]:
        """What does not change, and the past; see `deploy.telemetry.monitor.snapshot`."""
        with self._lock:
            return overview(self._view)

    def snapshot(self, since: int = -1) -> dict[str, Any]:
        """The present, and what happened after tick `since`."""
        with self._lock:
            return snapshot(self._view, self._clock(), since)

    def change(self, what: Callable[[FleetView, float], None]) -> None:
        """Let `what` work on the view at the present time, while no other thread reads it."""
        with self._lock:
            what(self._view, self._clock())


class Steerable(Source, ABC):
    """A `Source` that passes on what its viewers ask for; every method may be called from any thread."""

    @abstractmethod
    def steer(self, steer: Steer) -> None:
        """Ask for a pause, steps or a speed; takes effect soon, and shows in a later snapshot."""

    @abstractmethod
    def operate(self, operation: Operation) -> Future[Outcome]:
        """Ask the world for an operation; what is accepted shows in a later snapshot."""
