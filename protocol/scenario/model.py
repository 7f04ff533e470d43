"""A scenario: everything that determines a run, besides the transport. SI units, plain data.

Field names are the keys of the TOML file; a trailing underscore avoids a Python keyword (`from_` is `from` in
the file). Ranges are in the annotations; `protocol.scenario.tables` enforces them in files, msgspec in
messages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Annotated, Literal, get_args

from msgspec import Meta

from protocol.errors import Problem, ScenarioError, UsageError
from protocol.geometry import ConvexPolygon, Disk, Shape, defect
from protocol.scenario.body import (
    FARTHEST,
    PRESETS,
    Actuation,
    Base,
    Body,
    Length,
    NonNegative,
    Positive,
    Preset,
    Probability,
    RobotId,
    Span,
)
from protocol.scenario.network import Link, Network

LARGEST_GAIN = 1e12
Gain = Annotated[float, Meta(ge=1e-9, le=LARGEST_GAIN)]
Coordinate = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Angle = Annotated[float, Meta(ge=-1e3, le=1e3)]
HalfTurn = Annotated[float, Meta(ge=0, le=0.5)]
Position = tuple[Coordinate, Coordinate]
Corners = Annotated[tuple[Position, ...], Meta(min_length=1, max_length=64)]
LAWS = ("gradient", "reciprocal", "external")
Addition = Literal["obstacles", "jams", "late-states", "pace", "escape"]  # agents/law/additions.py
ADDITIONS: tuple[Addition, ...] = get_args(Addition)
LawName = Annotated[  # docs/guides/law.md
    str,
    Meta(
        pattern=rf"^({'|'.join(LAWS)}|(?s:.+:[^:]+))\Z",
        description=f"{', '.join(LAWS)}, or your own: module:Class, file.py:Class or entry-point:NAME",
    ),
]
GainChoice = Annotated[
    Gain | Literal["auto", "certified"], Meta(description='a number, "auto" or "certified"')
]
BodyChoice = Annotated[Preset | Body, Meta(description=f"a table or one of {', '.join(PRESETS)}")]
FaultKind = Literal["kill", "pause", "resume", "restart"]

CELLS = 4.0  # of the grid on which robots plan how to move parts, to the smallest radius
MOST_POINTS = 512  # that a robot has ahead, those of earlier orders included
MOST_CELLS = 1e6  # of that grid: some 50 MB of each robot's memory
DEFAULT_RADIUS = 0.30  # m, of the workspace
CROWD = 32  # robots, up to which each receives all States unless the scenario says otherwise
LARGE_MAP = 200  # obstacles, up to which it does


@dataclass(frozen=True, slots=True)
class Workspace:
    """What all robots share: a disk around the origin (`radius`, m), 0.30 m unless anything is given, or a
    convex polygon (`points`, m)."""

    radius: Length | None = None
    points: Corners | None = None

    def __post_init__(self) -> None:
        if self.radius is None and self.points is None:
            object.__setattr__(self, "radius", DEFAULT_RADIUS)

    def defect(self) -> str:
        """Why it has no shape; "" if it has one."""
        if self.points is None:
            return ""
        return (
            defect(self.points) if self.radius is None else "is given by `radius` or by `points`, not by both"
        )

    @property
    def shape(self) -> Shape:
        """The set that no disk leaves."""
        if self.points is not None:
            return ConvexPolygon(self.points)
        assert self.radius is not None
        return Disk(0.0, 0.0, self.radius)

    @property
    def disk_radius(self) -> float:
        """Radius of a round workspace, m; raises UsageError for a polygon."""
        if self.radius is None:
            raise UsageError("the workspace is a polygon; this is possible in a round one only")
        return self.radius


@dataclass(frozen=True, slots=True)
class Obstacle:
    """An obstacle: a disk (`center`, `radius`), or a convex polygon (`points`), m."""

    center: Position | None = None
    radius: Length | None = None
    points: Corners | None = None

    def defect(self) -> str:
        """The reason why its shape is invalid; "" if it is valid."""
        if self.points is not None and self.center is None and self.radius is None:
            return defect(self.points)
        if self.center is not None and self.radius is not None and self.points is None:
            return ""
        return "must be a disk, with `center` and `radius`, or a convex polygon, with `points`"

    @property
    def shape(self) -> Shape:
        """The set that no disk touches."""
        if self.points is not None:
            return ConvexPolygon(self.points)
        assert self.center is not None
        assert self.radius is not None
        return Disk(*self.center, self.radius)


@dataclass(frozen=True, slots=True)
class FloorPlan:
    """A map of map_server in place of obstacles, and of the workspace unless that is given.

    The file is looked for beside the scenario. Reading the scenario replaces it by its obstacles.
    """

    file: Annotated[str, Meta(min_length=1, max_length=1000, description="the name of a file")]
    error: Annotated[float, Meta(ge=0, le=10)] = 0.05  # m, by which obstacles may extend into free space
    unknown: Literal["occupied", "free"] = "occupied"  # cells that the map leaves unknown


@dataclass(frozen=True, slots=True)
class Part:
    """A part: a disk that robots carry to its goal (m)."""

    radius: Positive  # m
    start: Position  # m, of its centre
    goal: Position  # m


@dataclass(frozen=True, slots=True)
class Carrying:
    """How robots carry parts. A loaded robot is a disk of the larger radius of the two around its centre."""

    reach: Positive = 0.01  # m, the largest gap to a part across which it is taken up or put down


@dataclass(frozen=True, slots=True)
class Time:
    """Control period, limit (s of simulated time), arrival tolerance (m), and time of silence (s).

    An endless run has no verdict of its own: it continues until it is stopped.
    """

    step: Positive = 0.05  # s, control period
    limit: Positive = 60.0  # s of simulated time, after which the run is over
    tolerance: Positive = 0.005  # m, arrived when all robots at once are within this of their goals
    fence: Positive = 1.0  # s, a robot that is silent this long is announced as down
    deadlock: Positive = 20.0  # s without motion of any robot until the run ends
    endless: bool = False  # no verdict of its own: the run continues until it is stopped


@dataclass(frozen=True, slots=True)
class Control:
    """The law: desired velocity, speed limit and safety filter."""

    law: LawName = "gradient"
    k: GainChoice = "auto"
    filter: Literal["separating-lines", "none"] = "separating-lines"  # safety filter
    speed: Positive = 0.10  # m/s, limit
    additions: tuple[Addition, ...] = ADDITIONS  # gradient, reciprocal: additions to the paper's law
    lifetime: Positive = 0.5  # s, external: validity of a wish
    turn: Positive | None = None  # s; only one robot moves at a time, in the order of ids, each for this long

    def without(self, *names: Addition) -> Control:
        """The same without some additions."""
        return replace(self, additions=tuple(each for each in self.additions if each not in names))


@dataclass(frozen=True, slots=True)
class Sensing:
    """Measurement of a robot's own position: delay (s), noise and bias (m), dropout."""

    delay: Span = 0.0  # s, age of a measurement
    noise: NonNegative = 0.0  # m, standard deviation per axis, truncated at noise_bound
    noise_bound: NonNegative | None = None  # m, radius; three standard deviations unless given
    bias: Position = (0.0, 0.0)  # m, added to every measurement
    dropout: Probability = 0.0  # that a measurement is missing
    robots: Annotated[tuple[RobotId, ...], Meta(min_length=1)] | None = None  # all, unless named
    heading: HalfTurn = 0.0  # rad, largest error of the direction that a base takes itself to have
    # Measurements that exclude each other refute the bounds: stand still, or trust the newest one alone.
    contradiction: Literal["stand", "newest"] = "stand"

    @property
    def largest_noise(self) -> float:
        """Largest length of the noise alone, m."""
        bound = 3.0 * self.noise if self.noise_bound is None else self.noise_bound
        return bound if self.noise > 0.0 else 0.0

    @property
    def bound(self) -> float:
        """Largest error of one measurement, m: truncated noise plus bias."""
        return self.largest_noise + math.hypot(*self.bias)


@dataclass(frozen=True, slots=True)
class ProcessFault:
    """Something that happens to a robot's process at a time (s of simulated time)."""

    robot: RobotId
    at: NonNegative  # s of simulated time
    event: FaultKind


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """One robot: its disk, start and goal (m).

    Start and goal are of the disk's centre. A body that lies beside that has a direction, too.
    """

    id: RobotId  # unlike all others
    radius: Length  # m
    start: Position  # m
    goal: Position  # m
    heading: Angle = 0.0  # rad, at the start
    body: BodyChoice | None = None  # the scenario's, unless given
    base: Base | None = None  # the scenario's, unless given


@dataclass(frozen=True, slots=True)
class Journey:
    """An order to a robot: `points` to visit (m), one after another; without any it stays where it is."""

    robot: RobotId
    points: Annotated[tuple[Position, ...], Meta(max_length=MOST_POINTS)] = ()
    queue: bool = False  # after the points that are ahead, instead of at once
    patrol: bool = False  # repeat all points without end
    within: Positive | None = None  # s, after which it gives up and stays


@dataclass(frozen=True, slots=True, kw_only=True)
class Operation:
    """A change during the run, by an operator or the scenario: one of these."""

    goal: Journey | None = None
    add: RobotSpec | None = None  # it appears once all robots keep clear of its start
    remove: RobotId | None = None
    place: Obstacle | None = None  # it appears once all robots keep clear of it
    take: RobotId | None = None  # obstacle that is taken away
    halt: bool | None = None  # all robots stand; or are released
    release: Annotated[int, Meta(ge=0, le=2**63 - 1)] | None = None  # they are, if there were this many stops

    @property
    def asked(self) -> list[str]:
        """The fields that are given: one, unless it is malformed."""
        return [action for action in ACTIONS if getattr(self, action) is not None]

    def __str__(self) -> str:
        if self.goal is not None:
            return f"robot {self.goal.robot} is sent to {list(self.goal.points)}"
        if self.halt is not None or self.release is not None:
            return "emergency stop" if self.halt else "released"
        if self.add is not None or self.remove is not None:
            return f"robot {self.remove} goes" if self.add is None else f"robot {self.add.id} comes"
        return "an obstacle comes" if self.take is None else f"obstacle {self.take} goes"


ACTIONS = tuple(field.name for field in fields(Operation))


@dataclass(frozen=True, slots=True)
class Order(Operation):
    """An operation of the scenario; an impossible one is refused, with the reason in the result."""

    at: NonNegative  # s of simulated time


@dataclass(frozen=True, slots=True)
class World:
    """The plant: formulas, a physics engine (extra `mujoco`), or external bases, in real time."""

    plant: Literal["integrator", "mujoco", "external"] = "integrator"
    lease: Positive = 0.5  # s, external: a robot stands without a Tick for this time


@dataclass(frozen=True, slots=True)
class Scenario:
    """Everything that determines a run."""

    robots: Annotated[tuple[RobotSpec, ...], Meta(min_length=1, max_length=1000)]
    name: str = "scenario"  # name in results and of certificates
    description: str = ""
    seed: Annotated[int, Meta(ge=0, le=2**63 - 1)] = 0  # determines everything that is random in a run
    workspace: Workspace = Workspace()
    time: Time = Time()
    control: Control = Control()
    sensing: Annotated[tuple[Sensing, ...], Meta(max_length=1000)] = (Sensing(),)  # later ones outrank
    link: Link = Link()
    process: Annotated[tuple[ProcessFault, ...], Meta(max_length=10_000)] = ()
    actuation: Actuation = Actuation()
    world: World = World()
    body: BodyChoice = "point"  # of every robot that has none of its own
    base: Base | None = None  # of every robot that has none of its own
    map: FloorPlan | None = None  # adds its obstacles to `obstacles`
    obstacles: Annotated[tuple[Obstacle, ...], Meta(max_length=5000)] = ()  # the first is number 1
    parts: Annotated[tuple[Part, ...], Meta(max_length=100)] = ()  # disks to carry; the first is part 1
    carrying: Carrying = Carrying()
    orders: Annotated[tuple[Order, ...], Meta(max_length=1000)] = ()
    network: Network = Network()

    def ticks(self, seconds: float) -> int:
        """First tick at or after `seconds`; rounding below a tick is ignored."""
        return math.ceil(seconds / self.time.step - 1e-9)

    @property
    def k(self) -> float:
        """The number k; raises ScenarioError if `deploy.library.load` has not resolved it."""
        if isinstance(self.control.k, str):
            raise ScenarioError(
                self.name, [Problem("control.k", f'is still "{self.control.k}"; resolve it before the run')]
            )
        return self.control.k

    @property
    def hears_near(self) -> bool:
        """Whether each robot receives only the States of near peers."""
        if self.parts:
            return False  # part carriers plan with the ways of all robots
        interest = self.network.interest
        if interest is None:
            return (len(self.robots) > CROWD or len(self.obstacles) > LARGE_MAP) and not self.is_external
        return interest == "near"

    @property
    def shapes(self) -> dict[int, Shape]:
        """Obstacles at the start, by number; parts follow the listed ones."""
        parts = [Disk(*part.start, part.radius) for part in self.parts]
        return dict(enumerate([*(obstacle.shape for obstacle in self.obstacles), *parts], 1))

    def loaded_radius(self, robot: int, part: int) -> float:
        """Radius of a robot's disk while it carries a part, m."""
        return max(self.spec(robot).radius, self.parts[part - 1].radius)

    def resized(self, radii: Mapping[int, float]) -> Scenario:
        """The scenario with disks of other radii, m, for some robots."""
        robots = [replace(spec, radius=radii[spec.id]) if spec.id in radii else spec for spec in self.robots]
        return replace(self, robots=tuple(robots))

    @property
    def ids(self) -> tuple[int, ...]:
        """Robot ids in increasing order."""
        return tuple(sorted(robot.id for robot in self.robots))

    @property
    def newcomers(self) -> tuple[RobotSpec, ...]:
        """Robots that orders add."""
        return tuple(order.add for order in self.orders if order.add is not None)

    def spec(self, robot: int) -> RobotSpec:
        """The entry of one robot; raises KeyError for an unknown id."""
        robots = self.robots
        if 0 < robot <= len(robots) and robots[robot - 1].id == robot:
            return robots[robot - 1]  # as a rule they are numbered in order
        for spec in robots:
            if spec.id == robot:
                return spec
        raise KeyError(robot)

    def body_of(self, robot: int) -> Body:
        """The body of a robot."""
        own = self.spec(robot).body
        body = self.body if own is None else own
        plain, base = PRESETS[body] if isinstance(body, str) else body, self.base_of(robot)
        return plain if base is None or plain.kind == "point" else base.carries(plain)

    def base_of(self, robot: int) -> Base | None:
        """The external base of a robot."""
        own = self.spec(robot).base
        base = self.base if own is None else own
        return Base() if base is None and self.is_external else base

    @property
    def is_external(self) -> bool:
        """Whether the fleet is not simulated."""
        return self.world.plant == "external"

    @property
    def has_topics(self) -> bool:
        """Whether robots have ROS 2 topics."""
        bases = (self.base, *(spec.base for spec in self.robots))
        return self.is_external or any(base is not None and base.tools for base in bases)

    def sensing_of(self, robot: int) -> Sensing:
        """Sensing of a robot: the last entry that names it, or names none."""
        for sensing in reversed(self.sensing):
            if sensing.robots is None or robot in sensing.robots:
                return sensing
        return Sensing()


def gain_for_fleet(k: float, robots: int, present: int) -> float:
    """The gain for `present` robots, if `k` is that for `robots`.

    gamma is a sum over robots, so the repulsive layer gamma / k must become thinner with their number: by its
    square, as in the rule of k = "auto". A fleet that shrinks keeps its gain.
    """
    return k if present <= robots else min(LARGEST_GAIN, k * (present / robots) ** 2)
