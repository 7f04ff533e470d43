"""One body amid peers that move their lines, on a network that loses commands.

Body, lines and boundary are the product's. The model is the rest: a law that drives at whatever is there, a
base that misses what it is told by as much as it may, an estimate that is off by as much as it may, lines
that are offered anywhere, most of them where the body just passes them. What goes wrong is measured along
the true way, within ticks too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from random import Random
from types import ModuleType
from typing import Any

from agents.lines.polygon import around
from agents.peers.state import PeerState
from protocol.messages import BaseMotion, Member, Proposal
from protocol.scenario.body import PRESETS, Body
from tests.interpreted import Edit, interpreted

TICKS = 200
ROOMS = (0.3, 0.6, 2.0)  # m, largest distance of the own place from the middle
PARTS = 3  # places at which each arc is looked at
PEERS = (1, 2, 3)
OWN = 4
KINDS = ("point", "omnidirectional", "differential-drive", "spinning", "turtlebot3-burger", "e-puck")
ROUNDING = 1e-12  # m

Vector = tuple[float, float]

_MODULES = (
    "protocol.bodies.base",
    "protocol.bodies.sweep",
    *(f"agents.lines.{name}" for name in ("line", "own_set", "boundary", "ends", "tangent", "robot_pair")),
    "agents.lines.separating_lines",
    "agents.lines.safe_velocity",
    "agents.bodies.inertial",
)


class Product:
    """What the model takes from the product.

    Args:
        edits: what reads otherwise than in the sources; without any, what is compiled is taken as it is.
    """

    def __init__(self, edits: Sequence[Edit] = ()) -> None:
        if edits:
            loaded = dict(zip(_MODULES, interpreted(*_MODULES, edits=edits), strict=True))
        else:
            loaded = {name: _imported(name) for name in _MODULES}
        self.lines: Any = loaded["agents.lines.separating_lines"]
        self.boundary: Any = loaded["agents.lines.boundary"]
        self.inertial: Any = loaded["agents.bodies.inertial"]
        self.sweep: Any = loaded["protocol.bodies.sweep"]
        self.base: Any = loaded["protocol.bodies.base"]


def _imported(name: str) -> ModuleType:
    return __import__(name, fromlist=["*"])


def excess_of(seed: int, kind: str, product: Product, ticks: int = TICKS) -> float:
    """The most by which the body is ever beyond what it must obey, m; negative if it never is."""
    ride = Ride(seed, kind, product)
    return max(ride.tick() for _ in range(ticks))


class Ride:
    """One run, all of it drawn from its seed."""

    def __init__(self, seed: int, kind: str, product: Product) -> None:
        rng = self.rng = Random(f"{kind} {seed}")
        self.product = product
        self.period = rng.choice((0.02, 0.05, 0.1, 0.2))
        self.body = drawn(kind, rng)
        self.speed = rng.choice((0.05, 0.1, 0.3))
        sloppy = rng.random() < 0.5
        self.askew = rng.choice((0.0, 0.02, 0.2)) if sloppy else 0.0
        self.bound = rng.choice((0.0, 1e-3, 1e-2)) if sloppy else 0.0
        self.loss = rng.choice((0.0, 0.1, 0.5, 0.9))
        self.base = product.base.Base(self.body, self.period)
        self.filter = product.inertial.InertialBody(
            self.base,
            self.speed,
            product.sweep.Miss(self.body.error, self.body.lag, self.body.play),
            self.askew,
        )
        self.radius = rng.choice((0.05, 0.15))
        self.boundary = product.boundary.RoundBoundary(rng.choice(ROOMS))
        self.x = self.y = 0.0
        self.motion = product.base.Motion(rng.uniform(-4.0, 4.0))
        self.angle, self.number, self.now = 0.0, 0, 0
        self.restless = 0.5 if kind == "spinning" else 0.1  # how often it is to go elsewhere
        self.lines = self._lines()

    def _lines(self) -> Any:
        """Lines with three peers, half a metre away."""
        starts: dict[int, Vector] = {OWN: (0.0, 0.0)}
        for peer in PEERS:
            angle = self.rng.uniform(0.0, math.tau)
            starts[peer] = (0.5 * math.cos(angle), 0.5 * math.sin(angle))
        members = {peer: Member(peer, 1, "live", self.radius, founding=1) for peer in PEERS}
        return self.product.lines.SeparatingLines(
            OWN,
            1,
            dict.fromkeys(starts, self.radius),
            speed=self.speed,
            period=self.period,
            reach=self.filter.reach,
            members=members,
            starts=starts,
        )

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
        velocity = self.filter.velocity(self._desired(), at, self.lines.half_planes(), self.boundary, shape)
        if rng.random() < self.loss:
            return self._moved(None)
        return self._moved(self.product.base.turned(*velocity, -askew))

    def _said(self, askew: float) -> BaseMotion:
        """What the base says of itself; its direction is off."""
        motion, base = self.motion, self.base
        arc = base.halt(motion)
        dx, dy = self.product.base.chord(arc, base.turn(arc))
        stop = self.product.base.turned(dx, dy, motion.heading + askew)
        velocity = self.product.base.turned(*motion.velocity, askew)
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
        offer = Proposal(OWN, 1, self.number, -nx, -ny, offset)
        numbers = (rng.choice(PEERS), 1, self.now, True, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0)
        state = PeerState(*numbers, radius=self.radius, proposals=(offer,))
        self.lines.on_state(state)

    def _desired(self) -> Vector:
        rng = self.rng
        if rng.random() < self.restless:
            self.angle = rng.choice((rng.uniform(0.0, math.tau), math.atan2(self.y, self.x)))
        speed = rng.choice((0.0, 0.3, 1.0, 1.0, 1.0, 1.0)) * self.speed
        return speed * math.cos(self.angle), speed * math.sin(self.angle)

    def _moved(self, velocity: Vector | None) -> float:
        """Execute a tick."""
        worst = -math.inf
        sides = [side for pair in self.lines._each for side in pair.half_planes]
        for dx, dy in self._way(velocity):
            self.x += dx
            self.y += dy
            beyond = math.hypot(self.x, self.y) - self.boundary.radius
            worst = max(worst, beyond, *(-side.slack(self.x, self.y) for side in sides))
        return worst

    def _way(self, velocity: Vector | None) -> Iterator[Vector]:
        """The true displacements of a tick, one after another, each with its share of the error."""
        base, heading = self.base, self.motion.heading
        self.before = self.motion
        arcs, commanded = self._arcs(velocity)
        arc_type = self.product.base.Arc
        rng, body = self.rng, self.body
        size = rng.choice((0.0, 1.0)) * (1.0 - 1e-9)
        turn = rng.choice((self.angle, rng.uniform(0.0, math.tau)))
        ex, ey = size * math.cos(turn), size * math.sin(turn)
        fastest, late, done = math.hypot(self.before.ahead, self.before.aside), 0.0, 0
        for arc in arcs:
            part = arc_type(arc.ahead, arc.aside, arc.duration / PARTS)
            fastest = max(fastest, math.hypot(part.ahead, part.aside))
            way = math.hypot(part.ahead, part.aside) * part.duration
            for _ in range(PARTS):
                done += 1
                later = (body.lag * fastest + body.play) * done / (len(arcs) * PARTS) if commanded else 0.0
                missed, late = body.error * way + later - late, later
                turn = base.turn(part)
                dx, dy = self.product.base.turned(*self.product.base.chord(part, turn), heading)
                heading += turn
                yield dx + missed * ex, dy + missed * ey

    def _arcs(self, velocity: Vector | None) -> tuple[list[Any], bool]:
        """What the base does in this tick, and whether that is a command."""
        base, motion = self.base, self.motion
        if velocity is not None and velocity != (0.0, 0.0):
            ahead, aside = base.limited(motion, velocity)
            self.motion = base.driven(motion, ahead, aside)
            return base.drive(motion, ahead, aside), True
        arcs, parts = [], 4
        if velocity is not None:
            motion = base.braking(motion)
        for _ in range(parts):
            arcs.append(base.coast(motion, self.period / parts))
            motion = base.coasted(motion, self.period / parts)
        self.motion = motion
        return arcs, False


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
