"""Bodies amid peers that move their lines, on a network that loses commands, keep to what they must obey; the
product without one of its rules is found to leave it.

Body, plant, lines and boundary are the product's. The model is the rest: a law that drives at whatever is
there, errors of the base as large as they may be, most of them towards the nearest edge, an estimate that is
off by as much as it may, lines that are offered anywhere, most of them where the body just passes them. What
goes wrong is measured along the true way, within ticks too. Two mutants look right at first, and are off by
little: without the hold time, and without the way to the place where the body stands.
"""

import math
from functools import partial
from random import Random
from typing import Any

import pytest

from agents.lines.own_set import around
from agents.peers.neighbours import Neighbours
from agents.peers.state import PeerState
from protocol.bodies.kinematics import turned
from protocol.line import HalfPlane
from protocol.messages import BaseMotion, Grants, ListedBinding, Proposal
from protocol.scenario.body import PRESETS, Body
from tests.agents.lines.models.product import Product
from tests.interpreted import Edit, Mutant, without

pytestmark = pytest.mark.slow

TICKS = 200
ROOMS = (0.3, 0.6, 2.0)  # m, largest distance of the own place from the middle
PEERS = (1, 2, 3)
OWN = 4
KINDS = ("point", "omnidirectional", "differential-drive", "spinning", "turtlebot3-burger", "e-puck")
PERIODS = (0.01, 0.02, 0.05, 0.1, 0.2, 1.0)  # s
ROUNDING = 1e-12  # m

Vector = tuple[float, float]


def excess_of(seed: int, kind: str, product: Product, period: float | None = None) -> float:
    """The most by which the body is ever beyond what it must obey, m; negative if it never is."""
    ride = Ride(seed, kind, product, period)
    return max(ride.tick() for _ in range(TICKS))


def violation_of(seed: int, kind: str, product: Product, period: float | None = None) -> str:
    """By how much the body leaves what it must obey; "" if it does not."""
    excess = excess_of(seed, kind, product, period)
    return f"{kind}: beyond by {excess:.3g} m" if excess > ROUNDING else ""


class Ride:
    def __init__(self, seed: int, kind: str, product: Product, period: float | None = None) -> None:
        rng = self.rng = Random(f"{kind} {seed}")
        self.product = product
        self.period = rng.choice(PERIODS) if period is None else period
        self.body = drawn(kind, rng)
        self.speed = rng.choice((0.05, 0.1, 0.3))
        sloppy = rng.random() < 0.5
        self.askew = rng.choice((0.0, 0.02, 0.2)) if sloppy else 0.0
        self.bound = rng.choice((0.0, 1e-3, 1e-2)) if sloppy else 0.0
        self.loss = rng.choice((0.0, 0.1, 0.5, 0.9))
        kinematics = product.kinematics.Kinematics(self.body, self.period)
        self.filter = product.inertial.InertialBody(
            kinematics, self.speed, product.sweep.Tolerance(self.body, heading=self.askew)
        )
        self.base = product.plant.SimulatedBase(
            kinematics,
            product.sweep.Tolerance(self.body),
            product.kinematics.Motion(rng.uniform(-4.0, 4.0)),
            errors=self,
        )
        self.radius = rng.choice((0.05, 0.15))
        self.boundary = product.boundary.RoundBoundary(rng.choice(ROOMS))
        self.x = self.y = 0.0
        self.angle, self.number, self.now = 0.0, 0, 0
        self.restless = 0.5 if kind == "spinning" else 0.1  # how often it is to go elsewhere
        self.lines = self._lines()

    def _lines(self) -> Any:
        """Lines with three peers, half a metre away."""
        bindings = []
        for peer in PEERS:  # which own the lines
            angle = self.rng.uniform(0.0, math.tau)
            normal = (-math.cos(angle), -math.sin(angle))
            bindings.append(ListedBinding(10 + peer, peer, (*normal, -0.25)))
        lines = self.product.lines.SeparatingLines(
            OWN, self.radius, speed=self.speed, period=self.period, reach=self.filter.reach
        )
        lines.on_grants(
            Grants(1, 19, 8, None, tuple(bindings)), Neighbours(dict.fromkeys(PEERS, self.radius))
        )
        return lines

    def tick(self) -> float:
        """Go through a tick; the most by which the body is beyond what it must obey in it, m."""
        rng = self.rng
        self.now += 1
        off = rng.choice((0.0, 1.0)) * self.bound
        turn = rng.uniform(0.0, math.tau)
        at = (self.x + off * math.cos(turn), self.y + off * math.sin(turn))
        shape = around(self.bound, 1e-9) if self.bound > 0.0 else None
        askew = rng.choice((-1.0, 0.0, 1.0)) * self.askew
        self.filter.on_motion(self._said(askew))
        bound = 0.0 if shape is None else shape.radius
        self.lines.locate(self.now, at, bound, shape, self.filter.swept)
        for _ in range(rng.choice((0, 0, 1, 3))):
            self._propose()
        limits = self.product.inertial.Limits(at, self.lines.half_planes(), [self.boundary], shape)
        velocity = self.filter.velocity(self._desired(), limits)
        if rng.random() < self.loss:
            return self._moved(None)
        return self._moved(turned(*velocity, -askew))

    def at(self, tick: int) -> Vector:
        """The error of a command: as large as it may be, or none; ahead, anywhere, or to the nearest edge."""
        rng = self.rng
        size = rng.choice((0.0, 1.0, 1.0, 1.0)) * (1.0 - 1e-9)
        turn = rng.choice((self.angle, rng.uniform(0.0, math.tau), None, None))
        if turn is None:
            edge = min(self._sides(), key=lambda side: side.slack(self.x, self.y))
            return size * edge.nx, size * edge.ny
        return size * math.cos(turn), size * math.sin(turn)

    def _sides(self) -> list[HalfPlane]:
        """Everything that is obeyed."""
        away = math.hypot(self.x, self.y) or 1.0
        wall = HalfPlane(self.x / away, self.y / away, self.boundary.radius)
        return [wall, *(side for bond in self.lines._each for side in bond.half_planes)]

    def _said(self, askew: float) -> BaseMotion:
        """What the base says of itself; its direction is off."""
        motion = self.base.motion
        velocity = turned(*motion.velocity, askew)
        stop = turned(*self.base.report((0.0, 0.0)).stop, askew)
        return BaseMotion(velocity, motion.heading + askew, stop)

    def _propose(self) -> None:
        """A peer offers a line, often one that the body can only just satisfy."""
        rng = self.rng
        self.number += 1
        angle = rng.uniform(0.0, math.tau)
        if rng.random() < 0.6:
            angle = self.angle + rng.uniform(-0.5, 0.5)
        nx, ny = math.cos(angle), math.sin(angle)
        slack = rng.choice((0.0, 1e-6, 1e-3, 1e-2, 0.05)) + rng.choice((0.0, self.bound, 2.0 * self.bound))
        if self.filter.swept is not None and rng.random() < 0.7:
            slack += self.filter.swept.extent(nx, ny)
        offset = -(nx * self.x + ny * self.y + slack + self.radius)
        peer = rng.choice(PEERS)
        offer = Proposal(OWN, 10 + peer, self.number, -nx, -ny, offset)
        numbers = (peer, 1, self.now, True, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
        state = PeerState(*numbers, radius=self.radius, proposals=(offer,))
        self.lines.on_state(state)

    def _desired(self) -> Vector:
        rng = self.rng
        if rng.random() < self.restless:
            self.angle = rng.choice((rng.uniform(0.0, math.tau), math.atan2(self.y, self.x)))
        speed = rng.choice((0.0, 0.3, 1.0, 1.0, 1.0, 1.0)) * self.speed
        return speed * math.cos(self.angle), speed * math.sin(self.angle)

    def _moved(self, velocity: Vector | None) -> float:
        worst = -math.inf
        sides = [side for bond in self.lines._each for side in bond.half_planes]
        for dx, dy in self.base.move(velocity, self.now):
            self.x += dx
            self.y += dy
            beyond = math.hypot(self.x, self.y) - self.boundary.radius
            worst = max(worst, beyond, *(-side.slack(self.x, self.y) for side in sides))
        return worst


def drawn(kind: str, rng: Random) -> Body:
    """A body of a kind, or a preset, with errors or without."""
    error, lag, play = rng.choice(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.2, 0.01, 1e-3)))
    if kind == "point":
        return Body("point", error=error, lag=lag, play=play)
    if kind == "spinning":  # turns by several circles until it stands
        offset, track = rng.choice((0.01, 0.02, 0.05)), rng.uniform(0.03, 0.1)
        slows, holds = rng.choice((0.5, 2.0)), rng.choice((1.0, 3.0, 20.0))
        return Body("differential-drive", 0.1, offset, track, 1.0, slows, holds, error, lag, play)
    hold = rng.choice((0.0, 0.0, 0.02, 0.1, 0.5))
    acceleration = rng.choice((0.1, 0.5, 2.0, 50.0))
    if kind == "omnidirectional":
        return Body(kind, acceleration=acceleration, hold=hold, error=error, lag=lag, play=play)
    if kind == "differential-drive":
        track, offset = rng.uniform(0.03, 0.3), rng.uniform(0.02, 0.15)
        speed = rng.choice((0.1, 0.3))
        return Body(kind, 0.1, offset, track, speed, acceleration, hold, error, lag, play)
    return PRESETS[kind]


RIDES = 2  # the campaign `bodies` goes on
_KINEMATICS, _SWEEP, _INERTIAL, _OWN_SET = (
    "protocol.bodies.kinematics",
    "protocol.bodies.sweep",
    "agents.bodies",
    "agents.lines.own_set",
)
_RIDES = 400  # in which a mutant has to be found, at most
_PERIOD = 0.1  # s, at which all of them are found soon

_COASTED = "return Arc(motion.ahead, motion.aside, motion.hold + 0.5 * self._stopping(motion))"
ride_without = partial(without, model="omnidirectional")
MUTANTS = (
    ride_without(
        "hold",
        "a base that hears nothing goes on for its hold time before it brakes",
        Edit(_KINEMATICS, _COASTED, _COASTED.replace("motion.hold + ", "")),
    ),
    ride_without(
        "brake",
        "and then goes on until it stands",
        Edit(_KINEMATICS, _COASTED, _COASTED.replace(" + 0.5 * self._stopping(motion)", "")),
    ),
    ride_without(
        "finish-braking",
        "the whole way to where it stands is allowed, not only that place",
        Edit(_SWEEP, "for index, x in enumerate(self.xs):", "for index, x in list(enumerate(self.xs))[-1:]:"),
    ),
    ride_without(
        "adopt-swept",
        "a line is adopted only if it allows everything that follows from the commands that are out",
        Edit(_OWN_SET, "extent += self.swept.extent(nx, ny)", "pass"),
    ),
    ride_without(
        "reachable",
        "what is commanded is what the base can reach in a tick",
        Edit(
            _INERTIAL,
            "self._tolerance, kinematics.limited(motion, command))",
            "self._tolerance, turned(*command, -motion.heading))",
        ),
        Edit(
            _INERTIAL,
            "        ahead, aside = self._kinematics.limited(self._motion, velocity)\n",
            "        ahead, aside = turned(*velocity, -self._motion.heading)\n",
        ),
        Edit(_INERTIAL, "import Kinematics, Motion\n", "import Kinematics, Motion, turned\n"),
    ),
    ride_without(
        "one-factor",
        "braking scales both wheels by one factor; each by itself would leave the circle",
        Edit(
            _KINEMATICS,
            "        return Motion(heading, motion.ahead * left, motion.aside * left, 0.0)\n",
            "        across = motion.aside * self._half_track / self._offset\n"
            "        slower = self._acceleration * rest\n"
            "        pair = [math.copysign(max(0.0, abs(each) - slower), each)\n"
            "                for each in (motion.ahead - across, motion.ahead + across)]\n"
            "        across = 0.5 * (pair[1] - pair[0]) * self._offset / self._half_track\n"
            "        return Motion(heading, 0.5 * (pair[0] + pair[1]), across, 0.0)\n",
        ),
        model="differential-drive",
    ),
    ride_without(
        "arcs",
        "a body that turns describes arcs",
        Edit(_SWEEP, "        turn = kinematics.turn(piece)\n", "        turn = 0.0\n"),
        model="differential-drive",
    ),
    ride_without(
        "turning",
        "where a body that turns by more than half a circle will stand does not say how far it goes",
        Edit(_KINEMATICS, "0.5 * self._stopping(still)) > _TURNING:", "0.5 * self._stopping(still)) > 1e9:"),
        model="spinning",
    ),
    ride_without(
        "error",
        "a base misses what it is told by a share of its way",
        Edit(_SWEEP, "_Hull(error, slip)", "_Hull(0.0, slip)"),
    ),
    ride_without("slip", "and by its lag and play", Edit(_SWEEP, "_Hull(error, slip)", "_Hull(error, 0.0)")),
    ride_without(
        "change",
        "lag counts for the velocity that it had, even if the one commanded is small",
        Edit(_SWEEP, "tolerance.slip(motion, to)\n", "tolerance.slip(Motion(0.0), to)\n"),
    ),
    ride_without(
        "heading",
        "a base that takes itself to face elsewhere goes elsewhere",
        Edit(_SWEEP, "2.0 * math.sin(0.5 * heading)", "0.0 * heading"),
        model="differential-drive",
    ),
    ride_without(
        "sides-tested",
        "a velocity is commanded only if all that follows from it keeps to every line",
        Edit(_INERTIAL, "            if excess > 0.0:", "            if excess > 9.0:"),
        model="differential-drive",
    ),
    ride_without(
        "boundary-tested",
        "and inside the workspace",
        Edit(_INERTIAL, "            if fits and cut is None:", "            if fits:"),
        model="differential-drive",
    ),
)


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_never_leaves_what_it_must_obey(kind: str) -> None:
    product = Product()
    for seed in range(RIDES):
        assert violation_of(seed, kind, product) == "", f"seed {seed}"


@pytest.mark.parametrize("kind", KINDS)
def test_and_does_not_keep_to_it_by_standing(kind: str) -> None:
    """Of the way that it would go if nothing were in the way, some share; standing would give none."""
    product, way, most = Product(), 0.0, 0.0
    for seed in range(10):  # of fewer, some hardly have room to go anywhere
        ride = Ride(seed, kind, product, period=0.1)
        for _ in range(60):
            x, y = ride.x, ride.y
            ride.tick()
            way += abs(complex(ride.x - x, ride.y - y))
            most += ride.speed * ride.period
    assert way > 0.03 * most


@pytest.mark.campaign
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.rule)
def test_without_a_rule_it_does(mutant: Mutant) -> None:
    product = Product(mutant.edits)
    assert mutant.hunt(lambda seed: violation_of(seed, mutant.model, product, period=_PERIOD), _RIDES)
