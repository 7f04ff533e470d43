"""A fleet as a scene for Foxglove's 3D panel: messages of the run in, messages of the scene's topics out.

Every message is complete, so the newest of each topic suffices wherever a recording is opened. Robots are
drawn once, each in its own frame, which `/tf` moves at little cost.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Set
from itertools import chain
from typing import Generic, NamedTuple, TypeVar

import msgspec

from deploy.telemetry.drawing import Drawing, Json, example, frames, schema, update
from protocol import messages
from protocol.messages import Clock, GoalStatus, Health, Member, Message, Tick, Truth, Vector
from protocol.scenario.model import Scenario

T = TypeVar("T")


class Thinned(Generic[T]):
    """At most `limit` entries (even), each standing for equally many appended ones.

    When full, pairs of neighbours are merged by `merge(earlier, later)`; the last entry may still grow.
    """

    def __init__(self, limit: int, merge: Callable[[T, T], T]) -> None:
        self.items: list[T] = []
        self._limit, self._merge = limit + limit % 2, merge
        self._stride = 1  # appended entries per kept one
        self._count = 0

    def append(self, item: T) -> None:
        """Append an entry."""
        if self._count % self._stride:
            self.items[-1] = self._merge(self.items[-1], item)
        else:
            self._make_room()
            self.items.append(item)
        self._count += 1

    def _make_room(self) -> None:
        if len(self.items) == self._limit:
            pairs = zip(self.items[::2], self.items[1::2], strict=True)
            self.items = [self._merge(earlier, later) for earlier, later in pairs]
            self._stride *= 2


class Changes(NamedTuple):
    """Robots that appeared, and robots that left."""

    came: Set[int]
    went: Set[int]


_NO_CHANGES = Changes(frozenset(), frozenset())


class Cast:
    """The present disks, with radii and goals.

    An added robot is included once a message gives its radius.

    Attributes:
        radii: of robots that are present or in a roster, m.
        goals: of present robots, m, if a message gave them.
        strangers: ids of present disks of which no message gave the radius.
    """

    def __init__(self, scenario: Scenario) -> None:
        specs = [scenario.spec(robot) for robot in scenario.ids]
        self._newcomers = scenario.newcomers
        self.radii = {spec.id: spec.radius for spec in specs}
        self.goals = {spec.id: spec.goal for spec in specs}
        self._places = {spec.id: spec.start for spec in specs}
        self._truth = Truth(0, scenario.ids, tuple(self._places.values()), 0.0, 1.0)
        self._told = scenario.ids  # of the newest Truth
        self.strangers: Set[int] = frozenset()

    @property
    def places(self) -> dict[int, Vector]:
        """Positions of the present disks, by ascending id, m; their starts before the first Truth."""
        told = zip(self._truth.robots, self._truth.positions, strict=False)
        self._places.update((robot, place) for robot, place in told if robot in self._places)
        return self._places

    def meet(self, scenario: Scenario) -> None:
        """Take the specs of strangers from the world's present scenario."""
        self._newcomers += tuple(spec for spec in scenario.robots if spec.id in self.strangers)
        self._told, self.strangers = (), frozenset()

    def announce(self, members: Iterable[Member]) -> None:
        """Take the radii of a roster."""
        known = len(self.radii)
        self.radii.update((each.robot, each.radius) for each in members if each.status != "gone")
        if len(self.radii) > known:
            self._told = ()

    def __contains__(self, robot: int) -> bool:
        return robot in self._places

    def see(self, truth: Truth) -> Changes:
        """Take all positions; returns the robots that appeared and left."""
        self._truth = truth
        if truth.robots == self._told:
            return _NO_CHANGES
        self._told, before = truth.robots, self._places
        told = zip(truth.robots, truth.positions, strict=False)
        known = {spec.id for spec in self._newcomers} | self.radii.keys()
        self._places = {robot: place for robot, place in told if robot in known}
        self.strangers = frozenset(truth.robots) - known
        changes = Changes(self._places.keys() - before.keys(), before.keys() - self._places.keys())
        for robot in changes.went:  # another robot may get this id
            self.goals.pop(robot, None)
            self.radii.pop(robot, None)
        for robot in changes.came:
            self._welcome(robot, self._places[robot])
        return changes

    def _welcome(self, robot: int, place: Vector) -> None:
        """Take a newcomer's spec; of several orders for its id, that with the nearest start."""
        specs = [spec for spec in self._newcomers if spec.id == robot]
        if specs:
            spec = min(specs, key=lambda each: math.dist(each.start, place))
            self.radii[robot], self.goals[robot] = spec.radius, spec.goal


# -- the scene

_SECOND = 1_000_000_000  # ns of simulated time
_PERIODS = {
    "/tf": _SECOND // 10,
    "/measures": _SECOND // 10,
    "/scene/lines": _SECOND,
    "/scene/trails": 2 * _SECOND,
}
_TRAIL_POINTS = 512  # of all robots together
_LATEST = (1 << 31) * _SECOND  # end of Foxglove's time, ns


# The messages that a scene is made of.
DRAWN = frozenset((Truth, Health, GoalStatus, Clock, Tick))


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


_BEFORE = Truth(0, (), (), 0.0, 1.0)
_SCENE = _topic("foxglove.SceneUpdate", example())
TOPICS = {
    "/tf": _topic("foxglove.FrameTransforms", frames({"sec": 0, "nsec": 0}, {0: (0.0, 0.0)})),
    "/measures": _topic("disknav.Measures", measures(_BEFORE)),
    **dict.fromkeys(
        ("/scene/room", "/scene/robots", "/scene/goals", "/scene/lines", "/scene/trails"), _SCENE
    ),
}


class FleetScene:
    """The scene of one run, at the time of the newest Truth."""

    def __init__(self, scenario: Scenario) -> None:
        self._scenario, self._cast = scenario, Cast(scenario)
        self._drawing = Drawing(scenario, self._cast.radii)
        self._now = 0
        self._truth = _BEFORE
        self._down: frozenset[int] = frozenset()
        self._obstacles = dict(scenario.shapes)
        self._told = Clock(0, 0.0, (), (), "")
        self._lines: dict[int, tuple[messages.Line, ...]] = {}
        limit = max(8, _TRAIL_POINTS // len(scenario.ids))
        self._past: Thinned[dict[int, Vector]] = Thinned(limit, lambda _, later: later)
        self._next = dict.fromkeys(_PERIODS, 0)  # ns; next time of each topic
        self._due = 0  # ns; earliest of these
        self._draw = self._messages()

    def whole(self) -> Iterator[Picture]:
        """All topics, for a new viewer."""
        return chain.from_iterable(map(self.latest, TOPICS))

    def latest(self, topic: str) -> tuple[Picture, ...]:
        """Newest message of a topic; none of measures before the first Truth."""
        measured = topic != "/measures" or self._truth.robots
        return (self.picture(topic),) if measured else ()

    def picture(self, topic: str) -> Picture:
        return Picture(topic, self._now, msgspec.json.encode(self._draw[topic]()))

    def meet(self, scenario: Scenario) -> None:
        """Take the specs of added robots from the world's present scenario; the next Truth draws them."""
        self._cast.meet(scenario)

    def hear(self, message: Message) -> Iterator[Picture]:
        """Take a published message; returns the messages of the scene that change with it."""
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
        """Topics that change when a robot loses its life, or an obstacle appears or goes."""
        if clock.standing == self._told.standing and clock.obstacles == self._told.obstacles:
            return []
        self._told = clock
        before = self._down, self._obstacles
        self._down = frozenset(each.robot for each in clock.standing)
        gone = {obstacle.number for obstacle in clock.obstacles}
        came = {
            obstacle.number: obstacle.shape for obstacle in clock.obstacles if obstacle.status == "standing"
        }
        listed = {number: shape for number, shape in self._scenario.shapes.items() if number not in gone}
        self._obstacles = listed | came
        changed = (self._down != before[0], self._obstacles != before[1])
        return [topic for topic, new in zip(("/scene/robots", "/scene/room"), changed, strict=True) if new]

    def _on_truth(self, truth: Truth) -> list[str]:
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
            self._past.append(dict(self._cast.places))
        return changed + due

    def _recast(self, went: Set[int]) -> list[str]:
        """Update the drawn robots; returns the topics that change beside those that are due."""
        for robot in went:
            self._lines.pop(robot, None)
            for moment in self._past.items:
                moment.pop(robot, None)
        self._next, self._due = dict.fromkeys(_PERIODS, 0), 0
        return ["/scene/robots", "/scene/goals"]

    @property
    def _stamp(self) -> Json:
        return dict(zip(("sec", "nsec"), divmod(self._now, _SECOND), strict=True))

    # -- messages

    def _messages(self) -> dict[str, Callable[[], Json]]:
        draw, cast = self._drawing, self._cast
        return {
            "/tf": lambda: frames(self._stamp, cast.places),
            "/measures": lambda: measures(self._truth),
            "/scene/room": lambda: update([draw.room(self._stamp, self._obstacles.values())]),
            "/scene/robots": self._robots,
            "/scene/goals": lambda: update([draw.goals(self._stamp, cast.goals)]),
            "/scene/lines": lambda: update([draw.separating_lines(self._stamp, self._lines, cast.places)]),
            "/scene/trails": lambda: update([draw.trails(self._stamp, self._past.items, cast.places)]),
        }

    def _robots(self) -> Json:
        draw, stamp = self._drawing.robot, self._stamp
        there = [draw(stamp, robot, down=robot in self._down) for robot in self._cast.places]
        return update(there, stamp)
