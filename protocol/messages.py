"""Messages: the payload of each key. On the wire each is one msgpack array: a tag that names type and version
(`"state/6"`), then the fields in the order of their definition.

Units are SI: metres, seconds, metres per second. Times are integer ticks, t = tick * step. `incarnation`
numbers the lives of one robot id; the world assigns it on joining, and it only increases. `epoch` identifies
the coordinator of a run, and is drawn at random: messages of any other are refused. The comment beside a
field begins with its unit, if it has one; `docs/streams.md` is generated from them.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Final, Literal

import msgspec
from msgspec import Meta

from protocol.geometry import Shape, defect, shape_of
from protocol.line import UNIT, is_unit

VERSION = 6
HIGHEST_ID: Final = 999_999_999

Id = Annotated[int, Meta(ge=1, le=HIGHEST_ID)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
DiskId = Annotated[int, Meta(ge=-HIGHEST_ID, le=HIGHEST_ID)]
Epoch = Annotated[int, Meta(ge=0, le=2**32 - 1)]
LARGEST: Final = 1e15  # far above any number of a run; sums of its squares do not overflow
Real = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]  # NaN is within no bounds
Size = Annotated[float, Meta(ge=0, le=LARGEST)]
Square = Annotated[float, Meta(ge=0, le=LARGEST**2)]
Cosine = Annotated[float, Meta(ge=-UNIT, le=UNIT)]
Vector = tuple[Real, Real]
STILL: Final[Vector] = (0.0, 0.0)  # m/s
Heard = Annotated[tuple[Id, Count], Meta(extra={"names": ("peer", "tick")})]
Line = Annotated[tuple[Id, Cosine, Cosine, Real], Meta(extra={"names": ("peer", "nx", "ny", "limit")})]

Edge = Annotated[tuple[Cosine, Cosine, Real], Meta(extra={"names": ("nx", "ny", "offset")})]
Round = Annotated[tuple[Real, Real, Size], Meta(extra={"names": ("x", "y", "radius")})]


class Message(
    msgspec.Struct, frozen=True, array_like=True, gc=False, tag=lambda name: f"{name.lower()}/{VERSION}"
):
    """Base of all that is published: an array whose first element is `"<type>/<version>"`."""


class Proposal(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A separating line that the owner (lower id) offers to `peer`; it repeats the newest until answered."""

    peer: Id  # the follower, the higher id of the pair
    binding: Count  # number of the binding of the two
    number: Count  # increases per binding; older lines are ignored
    nx: Cosine  # x of the unit normal n, which points from owner to follower
    ny: Cosine  # y of n
    offset: Real  # m; owner keeps n.x + radius <= offset, follower n.x - radius >= offset


class Answer(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """The follower's (higher id) answer to proposals of the owner `peer`."""

    peer: Id  # the owner, the lower id of the pair
    binding: Count  # number of the binding of the two
    held: Count  # number of the line that the follower obeys, 0 for the first
    seen: Count  # highest number that it has answered


class FirstLine(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """The first line of a binding, for which this end was asked, and which it obeys from now on."""

    binding: Count  # number of the binding
    nx: Cosine  # x of the unit normal n, which points from the lower id to the higher
    ny: Cosine  # y of n
    offset: Real  # m, as of a Proposal

    def __post_init__(self) -> None:
        if not is_unit(self.nx, self.ny):
            raise ValueError(f"the normal of the first line of binding {self.binding} is not of length 1")


# The same obstacles come for every robot, and again until they are acknowledged.
_defect = lru_cache(maxsize=8192)(defect)
_shape_of = lru_cache(maxsize=8192)(shape_of)


class ListedBinding(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A binding in force, in the Tick to the life at one end."""

    number: Count  # version of the ledger that began it
    peer: DiskId  # the disk at the other end: a robot, or less than 0 an obstacle
    first: Edge | None = None  # m, first line; None: this end must choose it
    points: tuple[Vector, ...] = ()  # m, place of a static other end: centre or corners; empty if it may move
    radius: Size = 0.0  # m, of a static disk, error bound included
    static: bool = False  # whether it remains static as long as the binding is in force

    def __post_init__(self) -> None:
        if len(self.points) > 1 and (problem := _defect(self.points)):
            raise ValueError(f"the place of disk {self.peer} {problem}")
        if (self.static or self.first is None) and not self.points:
            raise ValueError(f"disk {self.peer} stands, and has no place")
        if self.first is not None and not is_unit(*self.first[:2]):
            raise ValueError(f"the normal of the first line towards disk {self.peer} is not of length 1")

    @property
    def place(self) -> Shape | None:
        """Place of a static other end."""
        return _shape_of(self.points, self.radius) if self.points else None


class Grants(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """The ledger's region and bindings for one life, complete."""

    life: Count  # number of this life in the ledger
    version: Count  # of the ledger
    number: Count  # of the newest region granted
    region: Round | None  # m, the disk in which to stay; None: anywhere
    bindings: tuple[ListedBinding, ...]  # all in force of this life

    def __post_init__(self) -> None:
        numbers = {each.number for each in self.bindings}
        if len(numbers) < len(self.bindings):
            raise ValueError("two bindings have one number")
        if max(self.life, self.number, *numbers) > self.version:
            raise ValueError(f"version {self.version} names a life, region or binding that is newer")


class Standing(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A static robot: no life up to this one moves again."""

    robot: Id  # the static robot
    incarnation: Count  # the life that ended
    position: Vector  # m, centre of the disk; of an external base as last reported


DiskStatus = Literal["live", "appearing", "standing", "gone"]


class Member(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """One id of the roster: its newest life, and the status of its disk."""

    robot: Id  # the robot of this disk
    incarnation: Count  # newest life that was admitted, 0 for none
    status: DiskStatus  # live: may move; appearing: nothing is there yet; standing: never moves in this life
    radius: Size  # m, of the disk
    position: Vector | None = None  # m, centre of a disk that is appearing or static
    bound: Size = 0.0  # m, the centre is at most this far from `position`

    def __post_init__(self) -> None:
        if self.position is None and self.status in ("appearing", "standing"):
            raise ValueError(f"robot {self.robot} is {self.status}, and has no place")


ObstacleStatus = Literal["appearing", "standing", "gone"]


class PlacedObstacle(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """An obstacle: a disk or a convex polygon."""

    number: Id  # of the obstacle; those that the scenario lists come first
    status: ObstacleStatus  # appearing: nothing is there yet; gone: nothing is there any more
    points: tuple[Vector, ...] = ()  # m, corners of a polygon, or the centre of a disk
    radius: Size = 0.0  # m, of a disk

    def __post_init__(self) -> None:
        problem = "" if self.status == "gone" or len(self.points) == 1 else _defect(self.points)
        if problem:
            raise ValueError(f"obstacle {self.number} {problem}")

    @property
    def shape(self) -> Shape:
        """Shape of a present or announced obstacle."""
        return _shape_of(self.points, self.radius)


class PartPlace(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """Where a part of the scenario is: on the floor, or on a robot."""

    part: Id  # its number
    obstacle: Count = 0  # number of its obstacle; of a carried part, the number reserved for it; 0 for none
    carrier: Count = 0  # the robot that has it, live or standing; 0 for none


class Roster(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """Membership, in one numbered version; versions only grow."""

    version: Count  # of two rosters the one with the higher number holds
    members: tuple[Member, ...]  # all ids that ever were in the run, ascending
    obstacles: tuple[PlacedObstacle, ...] = ()  # added or removed; others are the scenario's
    parts: tuple[PartPlace, ...] = ()  # all of the scenario, once the run is founded


class BaseMotion(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """The motion of a base as a tick begins, by its own report, in its estimate of the world's frame."""

    velocity: Vector  # m/s, of the robot's control point, the centre of its disk
    heading: Real  # rad, the direction that it faces
    stop: Vector  # m, from here to its stop without commands
    before: tuple[Vector, ...] = ()  # m/s, ahead and aside, oldest first: velocities that may act late


class Sense(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """Measurement and odometry of one robot, from base and localisation, or from a simulated plant."""

    position: Vector | None  # m, as measured; None when the measurement is missing
    stamp: Count  # tick at which `position` was true, not later than the one that begins
    bound: Size  # m, the true position at `stamp` is at most this far from `position`
    displacement: Vector  # m, odometry: motion during the previous tick, reported without delay
    displacement_bound: Size = 0.0  # m, what was executed is at most this far from `displacement`
    motion: BaseMotion | None = None  # motion of the base; None if it stands at the beginning of every tick


class Tick(Message, frozen=True, array_like=True, gc=False):
    """Coordinator to one robot, opens a tick: all commands of earlier ticks are settled."""

    robot: Id  # the addressee
    incarnation: Count  # the incarnation that is addressed
    tick: Count  # the tick that begins
    active: tuple[Id, ...]  # active robots whose States the addressee receives and awaits
    epoch: Epoch = 0  # of the coordinator
    sense: Sense | None = None  # None: the robot has an external base
    roster: Roster | None = None  # the newest one, until this incarnation has acknowledged it
    goal: Vector | None = None  # m, goal; None: unchanged, at first the scenario's
    halted: bool = False  # an emergency stop is in force: command no motion
    over: bool = False  # the run has ended: join again, as a new life or to receive the verdict
    heard: Count | None = None  # external fleet: tick of the newest Command of this incarnation that it has
    grants: Grants | None = None  # region and bindings to obey; None once this incarnation has them


class Report(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """Position estimate of a robot that is not simulated."""

    position: Vector  # m, centre of a set that contains the truth
    bound: Size  # m, the truth is at most this far from `position`


class Claim(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """Which part a robot fetches or carries. Of two that claim one, the nearer has it, then the lower id."""

    part: Id  # its number
    cost: Size  # m, the way that is left to it; 0 once the robot carries it
    radius: Size  # m, of the disk that the robot is with it, which peers leave room for


class State(Message, frozen=True, array_like=True, gc=False):
    """One robot to its peers: estimate, desired velocity, lines and claim."""

    robot: Id  # the sender
    incarnation: Count  # its life
    tick: Count  # the tick that this opens
    position: Vector | None  # m, own estimate; None before the first measurement
    bound: Size  # m, the truth is at most this far from `position`
    gamma: Square  # m^2, squared distance to the own goal, gamma_i
    slice: Size  # m, norm of the own gradient slice D_i, for the common pace
    desired: Vector  # m/s, velocity of the law, before the filter
    epoch: Epoch = 0  # of the coordinator that admitted this life
    proposals: tuple[Proposal, ...] = ()  # unanswered, on lines that it owns; of each peer the newest
    answers: tuple[Answer, ...] = ()  # to the owners of its other lines
    claim: Claim | None = None  # of the part that it fetches or carries


class Handling(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A robot's request to take a part up or put it down; repeated until the roster confirms it."""

    part: Id  # its number
    radius: Size  # m, of the disk around the own centre that is kept clear from now on
    place: Vector | None = None  # m, where to put it down; None: take it up


class Command(Message, frozen=True, array_like=True, gc=False):
    """One robot to the world: a velocity, valid for the named tick only."""

    robot: Id  # the sender
    incarnation: Count  # its life
    tick: Count  # the only tick in which this is executed
    velocity: Vector  # m/s, constant during the tick
    epoch: Epoch = 0  # of the coordinator that admitted this life
    roster: Count = 0  # newest version of the roster that this life has received
    awaits: tuple[Id, ...] = ()  # robots whose States are missing, so that there is no command yet
    report: Report | None = None  # external fleet: position as the tick begins; None if unknown
    version: Count = 0  # newest of the ledger that this life has adopted
    region: Count = 0  # number of the region that it obeys; 0 for none, so that it stands
    firsts: tuple[FirstLine, ...] = ()  # first lines that it has chosen, until the ledger lists them
    handles: Handling | None = None  # a part to be taken up or put down
    slice: Size | None = None  # m, norm of the own slice D_i, for the summary of the next tick

    @property
    def may_move(self) -> bool:
        """Whether its life may move its robot from then on; one that obeys no region stands."""
        return self.region != 0 or self.velocity != (0.0, 0.0)


class Clock(Message, frozen=True, array_like=True, gc=False):
    """World to all monitors: the tick that begins, the active robots, and those it waits for."""

    tick: Count  # the tick that begins, or that is waited for
    time: Size  # s, simulated time at its start
    active: tuple[Id, ...]  # robots that state and command this tick
    standing: tuple[Standing, ...]  # robots that are fenced, or that no process has joined for
    verdict: str  # empty while the run continues
    clearance: Real = 0.0  # m, smallest gap so far, over continuous time; negative is overlap
    phi: Real = 0.0  # navigation function, 0 at the goal, 1 on the boundary
    reason: str = ""  # for the verdict, for people
    founded: bool = False  # whether the first tick has begun; until then the world waits for every robot
    halted: bool = False  # whether an emergency stop is in force: all robots stand
    missed: Count = 0  # number of missing commands, over all robots and ticks so far
    rejected: dict[str, Count] = {}  # messages that the world dropped, by reason
    obstacles: tuple[PlacedObstacle, ...] = ()  # added or removed; others are the scenario's
    newcomers: tuple[Id, ...] = ()  # added robots with a disk, whose processes have not joined
    parts: tuple[PartPlace, ...] = ()  # places of the scenario's parts
    passed_over: tuple[tuple[Count, Id], ...] = ()  # tick and robot of each fault without a disk so far
    stops: Count = 0  # number of requests for an emergency stop so far, which a release names


class Summary(Message, frozen=True, array_like=True, gc=False):
    """World to all robots where some are far from each other: all positions as sensed."""

    tick: Count  # the tick that begins; takes effect two or three ticks later
    robots: bytes  # ids of all, ascending: of each run the first and how many, 4 bytes each, little-endian
    positions: bytes  # m, x and y of each as last measured, two 32-bit floats, little-endian
    gammas: bytes  # m^2, squared distances to their goals, one 32-bit float each, little-endian
    slices: bytes  # m, norms of their slices as last commanded, one 32-bit float each, little-endian
    epoch: Epoch = 0  # of the coordinator


class Truth(Message, frozen=True, array_like=True, gc=False):
    """World to all monitors: the true position of every disk at the start of `tick`. A disk that appears then
    is in the next Truth, not in this one."""

    tick: Count  # the tick that begins
    robots: tuple[Id, ...]  # their ids, ascending
    positions: tuple[Vector, ...]  # m, in the order of `robots`
    clearance: Real  # m, smallest gap during the tick before, over continuous time; negative is overlap
    phi: Real  # navigation function, 0 at the goal, 1 on the boundary
    log_potential: Real = 0.0  # log10(gamma^k / beta) / k, increases with phi; +-300 in place of infinity


class Health(Message, frozen=True, array_like=True, gc=False):
    """One robot about itself, a few times a second and at the end of a run."""

    robot: Id  # the sender
    incarnation: Count  # its life
    tick: Count  # its newest tick
    bound: Size  # m, error bound of the own position
    published: Count  # messages sent
    received: Count  # messages accepted
    rejected: dict[str, Count]  # messages dropped, by reason
    heard: tuple[Heard, ...]  # newest tick received from each peer
    lines: tuple[Line, ...]  # obeyed lines: the disk keeps n.x <= limit, in m
    note: str = ""  # for people


OrderStatus = Literal["under way", "arrived", "cancelled", "given up"]


class GoalStatus(Message, frozen=True, array_like=True, gc=False):
    """World about one robot's goal: whenever an order is accepted, a point reached, or the order ends."""

    robot: Id  # the robot of this goal
    tick: Count  # tick of this change
    number: Count  # of the order, counted by robot; 0 for the scenario's goal
    status: OrderStatus  # under way; arrived at the last point; cancelled; given up: its time was over
    goal: Vector  # m, the goal, or the place where it stays
    ahead: Count = 0  # points after this one; those of a patrol without end


class Wish(Message, frozen=True, array_like=True, gc=False):
    """A planner, a person or a policy to one robot whose law is "external": how it is to move."""

    robot: Id  # the robot to move
    velocity: Vector  # m/s; limited to the speed limit


LISTED: Final = 5000  # entries of a list of the report that may grow without limit


class Result(Message, frozen=True, array_like=True, gc=False):
    """World to the launcher at the end: the result. `report` is a JSON object."""

    report: str  # JSON text


AnyMessage = Tick | State | Command | Clock | Summary | Truth | Health | GoalStatus | Wish | Result
