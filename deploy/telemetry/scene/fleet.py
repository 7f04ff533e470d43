"""A fleet drawn for Foxglove's 3D panel: what a run says goes in, messages for topics of a scene come out.

Every message is whole: the newest of each topic shows all there is, wherever a recording is opened. Robots
are drawn once, each in a frame of its own that `/tf` moves, so that what moves costs little.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Set
from functools import partial
from itertools import chain
from typing import NamedTuple

import msgspec

from deploy.telemetry.scene import ros
from deploy.telemetry.scene.cast import Cast
from deploy.telemetry.scene.drawing import WORLD, Drawing, Moment, frame
from deploy.telemetry.scene.foxglove import Deletion, Entity, SceneUpdate, Time, schema
from deploy.telemetry.scene.thinned import Thinned
from protocol import messages
from protocol.messages import Clock, GoalStatus, Health, Message, Tick, Truth
from protocol.scenario.model import Scenario

_SECOND = 1_000_000_000  # ns of simulated time
_PERIODS = {
    "/tf": _SECOND // 10,
    "/measures": _SECOND // 10,
    "/scene/lines": _SECOND,
    "/scene/trails": 2 * _SECOND,
}
_TRAIL_POINTS = 512  # of all robots together, at most
_LATEST = (1 << 31) * _SECOND  # ns that ROS can tell; no tick of a real run is later


# What a scene is made of; asked of every message that is recorded, most of which are none of these.
DRAWN = frozenset((Truth, Health, GoalStatus, Clock, Tick))


class Measures(msgspec.Struct, frozen=True):
    """How the run stands: smallest gap during the tick before, m, and the navigation function with
    log10(gamma / beta^(1/k))."""

    clearance: float
    phi: float
    log_potential: float


class Topic(NamedTuple):
    """How the messages of a topic are to be read."""

    encoding: str
    schema: str
    schema_encoding: str
    definition: bytes


class Picture(NamedTuple):
    """One message: simulated time, ns, and payload."""

    topic: str
    time: int
    data: bytes


_SCENE = Topic("json", "foxglove.SceneUpdate", "jsonschema", schema(SceneUpdate, "foxglove.SceneUpdate"))
TOPICS = {
    "/tf": Topic("cdr", ros.NAME, "ros2msg", ros.DEFINITION.encode()),
    "/measures": Topic("json", "disknav.Measures", "jsonschema", schema(Measures, "disknav.Measures")),
    **dict.fromkeys(
        ("/scene/room", "/scene/robots", "/scene/goals", "/scene/lines", "/scene/trails"), _SCENE
    ),
}


class FleetScene:
    """The scene of one run; time is that of the newest truth."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._cast = scenario, Cast(scenario)
        self._drawing = Drawing(scenario, self._cast.radii)
        self._now = 0
        self._truth = Truth(0, (), (), 0.0, 1.0)
        self._down: frozenset[int] = frozenset()
        self._things = dict(scenario.shapes)
        self._told = Clock(0, 0.0, (), (), "")
        self._lines: dict[int, tuple[messages.Line, ...]] = {}
        limit = max(8, _TRAIL_POINTS // len(scenario.ids))
        self._past: Thinned[Moment] = Thinned(limit, lambda _, later: later)
        self._moving = self._frames_of_all()
        self._next = dict.fromkeys(_PERIODS, 0)  # ns; when a topic is due
        self._due = 0  # ns; when the first of them is
        self._draw: dict[str, Callable[[], bytes]] = {
            "/tf": self._frames,
            "/measures": self._measures,
            "/scene/robots": self._robots,
            **{topic: partial(_update, draw) for topic, draw in self._entities().items()},
        }

    def whole(self) -> Iterator[Picture]:
        """All of it, for who has just come."""
        return chain.from_iterable(map(self.latest, TOPICS))

    def latest(self, topic: str) -> tuple[Picture, ...]:
        """One topic of it; nothing of measures before anything was measured."""
        measured = topic != "/measures" or self._truth.robots
        return (self.picture(topic),) if measured else ()

    def picture(self, topic: str) -> Picture:
        """One topic of it."""
        return Picture(topic, self._now, self._draw[topic]())

    def meet(self, scenario: Scenario) -> None:
        """Take over what the world says of robots that an operator added: the next truth draws them."""
        self._cast.meet(scenario)

    def hear(self, message: Message) -> Iterator[Picture]:
        """Take over what was published; gives what is to be drawn anew because of it."""
        if isinstance(message, Tick):
            if message.roster is not None:
                self._cast.announce(message.roster.members)
        elif isinstance(message, Truth):
            return map(self.picture, self._on_truth(message))
        elif isinstance(message, Health) and message.robot in self._cast:
            self._lines[message.robot] = message.lines
        elif isinstance(message, GoalStatus) and message.robot in self._cast:
            self._cast.goals[message.robot] = message.goal
            return iter((self.picture("/scene/goals"),))
        elif isinstance(message, Clock):
            return map(self.picture, self._on_clock(message))
        return iter(())

    def _on_clock(self, clock: Clock) -> list[str]:
        """Which topics are changed by who is down, and by what came or went."""
        if clock.standing == self._told.standing and clock.things == self._told.things:
            return []
        self._told = clock
        before = self._down, self._things
        self._down = frozenset(each.robot for each in clock.standing)
        gone = {thing.number for thing in clock.things}
        came = {thing.number: thing.shape for thing in clock.things if thing.status == "standing"}
        listed = {number: shape for number, shape in self._scenario.shapes.items() if number not in gone}
        self._things = listed | came
        changed = (self._down != before[0], self._things != before[1])
        return [topic for topic, new in zip(("/scene/robots", "/scene/room"), changed, strict=True) if new]

    def _on_truth(self, truth: Truth) -> list[str]:
        """Which topics are due."""
        now = round(truth.tick * self._scenario.time.step * 1e9)
        if now >= _LATEST:
            return []
        self._now, self._truth = now, truth
        changes = self._cast.see(truth)
        changed = self._recast(changes.went) if any(changes) else []
        if now < self._due:
            return changed
        due = [topic for topic, time in self._next.items() if now >= time]
        for topic in due:
            self._next[topic] = now + _PERIODS[topic]
        self._due = min(self._next.values())
        if "/tf" in due:
            self._past.append(Moment(dict(self._cast.places)))
        return changed + due

    def _recast(self, went: Set[int]) -> list[str]:
        """Robots came or went; which topics that changes, beside those that are due at once."""
        for robot in went:
            self._lines.pop(robot, None)
            for moment in self._past.items:
                moment.forget(robot)
        self._moving = self._frames_of_all()
        self._next, self._due = dict.fromkeys(_PERIODS, 0), 0
        return ["/scene/robots", "/scene/goals"]

    def _frames_of_all(self) -> ros.Frames:
        return ros.Frames(WORLD, [frame(robot) for robot in self._cast.places])

    @property
    def _stamp(self) -> Time:
        return Time(*divmod(self._now, _SECOND))

    # -- what is drawn

    def _entities(self) -> dict[str, Callable[[], tuple[Entity, ...]]]:
        return {
            "/scene/room": self._room,
            "/scene/goals": self._goal_disks,
            "/scene/lines": self._separating_lines,
            "/scene/trails": self._trail_lines,
        }

    def _measures(self) -> bytes:
        return msgspec.json.encode(
            Measures(self._truth.clearance, self._truth.phi, self._truth.log_potential)
        )

    def _frames(self) -> bytes:
        return self._moving.message(self._now, self._cast.places.values())

    def _room(self) -> tuple[Entity, ...]:
        return (self._drawing.room(self._stamp, self._things.values()),)

    def _robots(self) -> bytes:
        """Those that are there; who was drawn before and is not one of them goes."""
        draw, stamp = self._drawing.robot, self._stamp
        there = tuple(draw(stamp, robot, down=robot in self._down) for robot in self._cast.places)
        return msgspec.json.encode(SceneUpdate(there, (Deletion(stamp),)))

    def _goal_disks(self) -> tuple[Entity, ...]:
        return (self._drawing.goals(self._stamp, self._cast.goals),)

    def _trail_lines(self) -> tuple[Entity, ...]:
        return (self._drawing.trails(self._stamp, self._past.items, self._cast.places),)

    def _separating_lines(self) -> tuple[Entity, ...]:
        return (self._drawing.separating_lines(self._stamp, self._lines, self._cast.places),)


def _update(draw: Callable[[], tuple[Entity, ...]]) -> bytes:
    return msgspec.json.encode(SceneUpdate(draw()))
