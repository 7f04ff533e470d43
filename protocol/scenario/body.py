"""Bodies of robots: a point, a base with inertia, or two wheels; messages and delays of external bases."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Annotated, Any, Final, Literal, NamedTuple

from msgspec import Meta

from protocol.errors import UsageError

# The bounds of size keep squares and products of lengths away from the ends of a double's range.
# Rounding of coordinates stays a tenth of the nanometre with which lines are kept (docs/safety.md, A8).
FARTHEST: Final = 1e5  # m, of a coordinate
Length = Annotated[float, Meta(ge=1e-9, le=FARTHEST)]
Positive = Annotated[float, Meta(ge=1e-9, le=1e6)]
NonNegative = Annotated[float, Meta(ge=0, le=1e6)]
Share = Annotated[float, Meta(ge=0, le=0.9)]
Probability = Annotated[float, Meta(ge=0, le=1)]
# The number has its range from `checks`: msgspec 0.22 fails on one that is bounded beside a tuple.
Span = Annotated[
    float | tuple[NonNegative, NonNegative], Meta(description="a number of seconds or an array [low, high]")
]
RobotId = Annotated[int, Meta(ge=1, le=999_999_999)]

BodyKind = Literal["point", "omnidirectional", "differential-drive"]
Preset = Literal[
    "point", "turtlebot3-burger", "turtlebot3-waffle", "turtlebot4", "create3", "robotarium", "e-puck"
]


@dataclass(frozen=True, slots=True)
class Body:
    """A robot's body. A Command sets the velocity of its control point, the centre of its disk.

    point: takes any velocity at once, and stands without a command. The others hold the last velocity for
    `hold`, then brake. omnidirectional: moves into all directions. differential-drive: two wheels; the
    control point lies `offset` ahead of the middle of their axle.
    """

    kind: BodyKind = "point"
    radius: Length | None = None  # m, of the hull around its middle; the disk has `offset` more
    offset: NonNegative = 0.0  # m, differential drive: from the axle's middle to the control point
    track: NonNegative = 0.0  # m, differential drive: between the wheels
    speed: Positive = 1e6  # m/s, of a wheel's rim; without wheels of the whole
    acceleration: Positive = 1e6  # m/s^2, of the same, speeding up and braking
    hold: NonNegative = 0.0  # s for which it holds the last velocity after its tick
    # It is off its nominal way by at most `error` of that, `lag` (s) times its largest change of velocity,
    # and `play` (m) together (`protocol.bodies.sweep`); odometry of a tick is off by at most `odometry` of
    # the way and `drift` (m).
    error: Share = 0.0
    lag: NonNegative = 0.0
    play: NonNegative = 0.0
    odometry: Share = 0.0
    drift: NonNegative = 0.0

    @property
    def ideal(self) -> bool:
        """Whether it executes Commands at once and exactly, for any odometry."""
        return self.kind == "point" and self.error == self.lag == self.play == 0.0

    @property
    def disk(self) -> float | None:
        """Radius of the disk around the control point that contains the hull, m."""
        return None if self.radius is None else self.radius + self.offset


def _two_wheels(radius: float, track: float, speed: float, offset: float, play: float = 8e-4) -> Body:
    return Body(
        "differential-drive",
        radius,
        offset,
        track,
        speed,
        acceleration=0.66,
        hold=0.1,
        error=0.08,
        lag=0.015,
        play=play,
        odometry=0.1,
        drift=5e-4,
    )


# Radius, track and speed are the makers'. Acceleration and offset are choices: a wheel that gains 0.66 m/s
# in a second does not spin on a smooth floor; an offset of a third of the track turns briskly. The errors are
# what all of their models in MuJoCo keep to, at the periods between these that were measured
# (`tests/world/plants/deviations.py`).
SHORTEST: Final = 0.01  # s
LONGEST: Final = 1.0  # s
BRISKEST: Final = 1.5  # m/s^2, acceleration of wheels up to which they do
PRESETS: Final[dict[str, Body]] = {
    "point": Body(),
    "turtlebot3-burger": _two_wheels(0.10, 0.160, 0.22, 0.05),
    "turtlebot3-waffle": _two_wheels(0.20, 0.287, 0.26, 0.09, 12e-4),
    "turtlebot4": _two_wheels(0.175, 0.233, 0.306, 0.08, 12e-4),
    "create3": _two_wheels(0.175, 0.233, 0.306, 0.08, 12e-4),
    "robotarium": _two_wheels(0.055, 0.11, 0.20, 0.035),
    "e-puck": _two_wheels(0.035, 0.053, 0.13, 0.02),
}


TOPICS = ("velocity", "odometry", "pose", "desired")
FRAMES = ("map_frame", "odometry_frame", "base_frame")
_CHARACTER = r"(?:[A-Za-z0-9_.-]|\{id\})"
_NAME = re.compile(rf"/?(?:{_CHARACTER}+(?:/{_CHARACTER}+)*/?)?")
_Text = Annotated[str, Meta(max_length=200, description="of at most 200 characters")]
STEP: Final = 0.02  # s, longest step of the velocities for an external base
DECISION: Final = 0.05  # s from the beginning of a tick to its Command at most, else an external base brakes


class Lateness(NamedTuple):
    """Delays of an external base, s."""

    age: float  # greatest true age of the odometry with which a velocity is decided
    latency: float  # longest time from when a velocity is due to its execution by the base
    alone: float  # longest time for which a base holds its last velocity once its robot's process is dead
    spread: float  # error of the time for which the heading is predicted

    @property
    def window(self) -> float:
        """Time for which earlier velocities matter, s."""
        return self.age + self.latency


@dataclass(frozen=True, slots=True)
class Base:
    """The external base and localisation of a robot: its topics, times and dialect.

    ros2: by ROS 2 messages over zenoh, in the dialect of zenoh-bridge-ros2dds or of rmw_zenoh: a Twist or
    TwistStamped to the base; Odometry from it, and a PoseStamped from a localisation; with the law
    "external", another Twist or TwistStamped from a planner. In every text, `{id}` is replaced by the robot's
    id.
    """

    kind: Literal["ros2"] = "ros2"
    dialect: Literal["ros2dds", "rmw_zenoh"] = "ros2dds"
    domain: Annotated[int, Meta(ge=0, le=232)] = 0  # ROS_DOMAIN_ID, of rmw_zenoh
    tools: bool = False  # whether the robot serves tools of ROS such as RViz, simulated or not
    namespace: _Text = "/bot{id}"  # "/" for a robot that has none
    velocity: _Text = "cmd_vel"
    stamped: bool = False  # whether velocities are TwistStamped, else Twist
    odometry: _Text = "odom"
    pose: _Text = "pose"
    desired: _Text = "cmd_vel_desired"  # wishes of a planner, if the law is "external"
    map_frame: _Text = "map"  # of poses; the workspace is described in it
    odometry_frame: _Text = "odom"
    base_frame: _Text = "base_link"  # frame of odometry and poses: the middle of the axle
    timeout: Positive = 0.25  # s without a velocity, after which the base begins to brake by itself
    patience: NonNegative = 0.1  # s without a tick, after the one it is in, until the robot has it brake
    latency: NonNegative = 0.03  # s that a message between robot and base may take, one way
    delay: NonNegative = 0.0  # s that odometry takes at least
    age: Positive = 0.1  # s, besides `latency`, that the odometry may be old with which a tick begins

    def carries(self, body: Body) -> Body:
        """The body, with the longest hold time of this base."""
        return replace(body, hold=self.lateness.alone + max(self.patience, STEP))

    @property
    def lateness(self) -> Lateness:
        """The delays of this base.

        A tick begins with odometry of an estimated age of at most `age + latency`. The estimate takes the
        least delay seen for `delay`; it is between that and `latency`.
        """
        unknown = self.latency - self.delay
        return Lateness(
            self.age + self.latency + unknown,
            self.latency,
            self.timeout + self.latency,
            0.5 * (unknown + DECISION),
        )

    def of(self, robot: int) -> Base:
        """The base of one robot: its id in place of `{id}`."""
        names = ("namespace", *TOPICS, *FRAMES)
        named: dict[str, Any] = {name: getattr(self, name).replace("{id}", str(robot)) for name in names}
        return replace(self, **named)

    def topic(self, name: str) -> str:
        """The full name of a topic, without its first slash.

        A name that begins with a slash is in no namespace, except for the bridge, which puts all names into
        its own.
        """
        is_full = self.dialect == "rmw_zenoh" and name.startswith("/")
        return f"{'' if is_full else self.namespace.strip('/')}/{name.strip('/')}".lstrip("/")


@dataclass(frozen=True, slots=True)
class Actuation:
    """Executed velocity = v + |v| w; `noise` is the deviation of w per axis, truncated at three of them."""

    noise: Annotated[float, Meta(ge=0, le=0.3)] = 0.0

    @property
    def bound(self) -> float:
        """Largest |w|."""
        return 3.0 * self.noise


def ros_name(text: str) -> str:
    """Return `text` if it is a valid name of a namespace or topic; raises UsageError."""
    if not _NAME.fullmatch(text):
        raise UsageError(
            f"{text!r} is no ROS name: letters, digits, '_', '-' and '.', with one '/' between words, "
            "and {id} for the robot's id"
        )
    return text


def span_of(span: float | tuple[float, float]) -> tuple[float, float]:
    """Low and high end of a span, s."""
    return span if isinstance(span, tuple) else (span, span)
