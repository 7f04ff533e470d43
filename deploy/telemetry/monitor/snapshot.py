"""The view as plain data for viewers, and its thread-safe source."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

from deploy.telemetry.live import FleetView, RobotView
from protocol.geometry import Disk, Shape
from protocol.messages import PlacedObstacle, Truth
from protocol.scenario.model import Time

T = TypeVar("T")
_SAMPLES = 8  # past samples in a snapshot


def overview(view: FleetView) -> dict[str, Any]:
    """Constants of a run, and its past, for a new viewer."""
    document: dict[str, Any] = {"kind": "overview", "epoch": view.epoch, "run": view.run, "scenario": None}
    if view.scenario is not None:
        scenario = view.scenario
        document |= {
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
    return document


def _outline(shape: Shape) -> dict[str, Any]:
    if isinstance(shape, Disk):
        return {"center": (shape.x, shape.y), "radius": shape.radius}
    return {"points": shape.points}


def _change(obstacle: PlacedObstacle) -> dict[str, Any] | None:
    return None if obstacle.status == "gone" else _outline(obstacle.shape) | {"status": obstacle.status}


def _still(robot: RobotView) -> dict[str, Any]:
    spec = robot.spec
    trail = [[round(x, 5), round(y, 5)] for x, y in robot.trail.items]
    goal = robot.errand.goal
    return {"id": spec.id, "radius": spec.radius, "start": spec.start, "goal": goal, "trail": trail}


def snapshot(view: FleetView, now: float, since: int = -1) -> dict[str, Any]:
    """The present state, with a few samples of the time since tick `since`."""
    newest = max((robot.tick for robot in view.robots.values()), default=0)
    rules, ended = view.scenario.time if view.scenario else Time(), bool(view.verdict)
    return {
        "kind": "frame",
        "epoch": view.epoch,
        "run": view.run,
        "phase": view.phase,
        "stops": view.stops,
        "tick": view.tick,
        "time": round(view.tick * rules.step, 6),
        "pace": view.ticks_per_second(now),
        "verdict": view.verdict,
        "reason": view.reason,
        "steering": {"paused": view.steering.paused, "speed": view.steering.speed},
        "smallest": view.smallest,
        "robots": [robot.row(now, newest, rules.tolerance, ended=ended) for robot in view.robots.values()],
        "samples": _samples(view, since),
        "obstacles": {str(obstacle.number): _change(obstacle) for obstacle in view.obstacles},
    }


def _samples(view: FleetView, since: int) -> list[list[Any]]:
    """At most `_SAMPLES` Truths after `since`, each with the smallest clearance since the one before."""
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
    """A view with a lock: one thread writes, others read. Every method may be called from any thread."""

    def __init__(self, run: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._view = FleetView(run)
        self._lock = threading.Lock()
        self._clock = clock

    def overview(self) -> dict[str, Any]:
        with self._lock:
            return overview(self._view)

    def snapshot(self, since: int = -1) -> dict[str, Any]:
        """The present state, and samples of the time since tick `since`."""
        with self._lock:
            return snapshot(self._view, self._clock(), since)

    def change(self, what: Callable[[FleetView, float], T]) -> T:
        """Result of `what`, called with the view and the present time, under the lock."""
        with self._lock:
            return what(self._view, self._clock())
