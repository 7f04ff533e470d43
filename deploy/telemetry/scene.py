"""A fleet as a scene for Foxglove's 3D panel: a view of the run in, messages of the scene's topics out.

Every message is complete, so the newest of each topic suffices wherever a recording is opened. Robots are
drawn once, each in its own frame, which `/tf` moves at little cost.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import msgspec

from deploy.telemetry import drawing
from deploy.telemetry.drawing import Json, example, frames, schema, update
from deploy.telemetry.live import FleetView
from protocol.messages import Clock, GoalStatus, Message, Truth

_SECOND = 1_000_000_000  # ns of simulated time
_PERIODS = {
    "/tf": _SECOND // 10,
    "/measures": _SECOND // 10,
    "/scene/lines": _SECOND,
    "/scene/trails": 2 * _SECOND,
}
_TRAIL_POINTS = 512  # of all robots together


def measures(truth: Truth) -> Json:
    """Smallest gap in the last tick, m, navigation function, and log10(gamma / beta^(1/k))."""
    return {"clearance": truth.clearance, "phi": truth.phi, "log_potential": truth.log_potential}


class SceneTopic(NamedTuple):
    """JSON schema of a topic, with its name."""

    schema: str
    definition: bytes


class Picture(NamedTuple):
    """One message: topic, simulated time, ns, and payload."""

    topic: str
    time: int
    data: bytes


def _topic(name: str, example: Json) -> SceneTopic:
    return SceneTopic(name, schema(name, example))


_SCENE = _topic("foxglove.SceneUpdate", example())
TOPICS = {
    "/tf": _topic("foxglove.FrameTransforms", frames({"sec": 0, "nsec": 0}, [drawing.EXAMPLE])),
    "/measures": _topic("disknav.Measures", measures(Truth(0, (), (), 0.0, 1.0))),
    **dict.fromkeys(
        ("/scene/room", "/scene/robots", "/scene/goals", "/scene/lines", "/scene/trails"), _SCENE
    ),
}


class FleetScene:
    """The scene of a view that knows its scenario, at the time of the newest Truth."""

    def __init__(self, view: FleetView) -> None:
        self._view = view
        self._next = dict.fromkeys(_PERIODS, 0)  # ns; next time of each topic
        self._epoch = view.epoch
        self._tick = 0  # of the newest Truth drawn
        self._shown = self._content()

    def whole(self) -> Iterable[Picture]:
        """All topics, for a new viewer."""
        return (picture for topic in TOPICS for picture in self.latest(topic))

    def latest(self, topic: str) -> tuple[Picture, ...]:
        """Newest message of a topic; none of measures before the first Truth."""
        return (self.picture(topic),) if topic != "/measures" or self._view.recent else ()

    def after(self, message: Message) -> list[Picture]:
        """Messages that change with one which the view has taken: those that are due at a Truth, and those
        of robots, goals and obstacles that differ.
        """
        if not isinstance(message, Truth | Clock | GoalStatus):
            return []
        before, self._shown = self._shown, self._content()
        topics = [topic for topic, content in self._shown.items() if content != before[topic]]
        if self._epoch != self._view.epoch:  # robots appeared or left
            self._epoch, self._next = self._view.epoch, dict.fromkeys(_PERIODS, 0)
        if self._view.recent and self._view.recent[-1].tick > self._tick:
            self._tick = self._view.recent[-1].tick
            due = [topic for topic, time in self._next.items() if self._now >= time]
            self._next.update((topic, self._now + _PERIODS[topic]) for topic in due)
            topics += due
        return list(map(self.picture, topics))

    def picture(self, topic: str) -> Picture:
        return Picture(topic, self._now, msgspec.json.encode(self._drawn(topic)))

    def _content(self) -> dict[str, tuple[Any, ...]]:
        """What the messages show that are sent at changes only."""
        robots = self._view.robots.items()
        return {
            "/scene/room": self._view.obstacles,
            "/scene/robots": tuple((robot, each.radius, each.fenced) for robot, each in robots),
            "/scene/goals": tuple((robot, each.goal) for robot, each in robots),
        }

    @property
    def _now(self) -> int:
        """Time of the newest Truth, ns."""
        assert self._view.scenario is not None
        tick = self._view.recent[-1].tick if self._view.recent else 0
        return round(tick * self._view.scenario.time.step * 1e9)

    def _drawn(self, topic: str) -> Json:
        view, stamp = self._view, dict(zip(("sec", "nsec"), divmod(self._now, _SECOND), strict=True))
        assert view.scenario is not None
        robots = view.robots.values()
        match topic:
            case "/tf":
                return frames(stamp, robots)
            case "/measures":
                return measures(view.recent[-1])
            case "/scene/room":
                drawn = drawing.room(stamp, view.scenario.workspace.shape, view.shapes.values())
            case "/scene/robots":
                return update([drawing.disk(stamp, robot) for robot in robots], stamp)
            case "/scene/goals":
                drawn = drawing.goals(stamp, robots)
            case "/scene/lines":
                drawn = drawing.separating_lines(stamp, view.robots)
            case _:
                drawn = drawing.trails(stamp, robots, max(8, _TRAIL_POINTS // max(1, len(robots))))
        return update([drawn])
