"""Nothing touches while disks grow and shrink; without any one rule for that something does.

Whole robots take parts up and put them down wherever they are near, while everything goes wrong. As in
`tests.agents.lines.models.skirmishes` they want to collide; one that is near a part asks for it, and a
carrier asks to put its part down beside itself, whether that makes sense or not.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import Any

import pytest

from agents.peers.neighbours import Neighbours
from protocol.messages import Claim, Handling
from protocol.scenario.model import Carrying, Part, Scenario
from tests.agents.lines.models.product import Product
from tests.agents.lines.models.skirmishes import skirmish
from tests.agents.lines.models.skirmishes.arena import Attack
from tests.interpreted import Edit, Mutant, without

pytestmark = pytest.mark.slow

_ROBOT, _FILTER, _PARTS = "agents.robot", "agents.safety_filter", "world.coordinator.parts"
_RUNS = 1_000  # random ones in which a mutant has to be found, at most, wherever they begin

REACH = 0.03  # m

Vector = tuple[float, float]


def violation_of(seed: int, product: Product, ticks: int = 2 * skirmish.TICKS) -> str:
    """What goes wrong in the run with this seed; "" if nothing does."""
    return skirmish.first_violation(Haul(seed, product), ticks)


class Haul(skirmish.Skirmish):
    """One run, all of it drawn from its seed.

    Attributes:
        handled: how often a part was taken up, or let go.
    """

    def __init__(self, seed: int, product: Product) -> None:
        self.handled = 0
        super().__init__(seed, product)

    def _drawn(self, seed: int, rng: Random) -> Scenario:
        plain = super()._drawn(seed, rng)
        return replace(
            plain, obstacles=(), parts=_parts(Random(f"parts {seed}"), plain), carrying=Carrying(REACH)
        )

    def tick(self) -> None:
        parts = self.world.parts
        before = parts.places
        super().tick()
        self.handled += [each.carrier for each in before] != [each.carrier for each in parts.places]

    def _live(self, process: Any, robot: int) -> None:
        super()._live(process, robot)
        process.core._mover = _Porter(self.rng, self.scenario, robot)

    def _open(self, process: Any) -> None:
        process.core._law = Attack(self.rng, self.world, process.core.robot)
        super()._open(process)


class _Porter:
    """Asks for what is near, for some ticks; and to put down what it has."""

    def __init__(self, rng: Random, scenario: Scenario, robot: int) -> None:
        self._rng, self._scenario, self._robot = rng, scenario, robot
        self._place: Vector | None = None
        self.goal = (0.0, 0.0)
        self.aim = None
        self.claim: Claim | None = None
        self.radius, self.handles, self.held = 0.0, None, 0

    def look(self, _: int, position: Vector, peers: Neighbours, *__: Any) -> None:
        self.radius, self.claim, self.held = self._scenario.spec(self._robot).radius, None, 0
        self.handles: Handling | None = None
        carried = next((each.part for each in peers.parts if each.carrier == self._robot), 0)
        if carried:
            self._put(carried, position)
        else:
            self._take(position, peers)

    def _put(self, part: int, position: Vector) -> None:
        self.radius = self._scenario.loaded_radius(self._robot, part)
        if self._place is None or self._rng.random() < 0.1:
            angle, away = math.tau * self._rng.random(), REACH * self._rng.random()
            distance = self.radius + self._scenario.parts[part - 1].radius + away
            self._place = position[0] + distance * math.cos(angle), position[1] + distance * math.sin(angle)
        self.handles = Handling(part, self.radius, self._place)

    def _take(self, position: Vector, peers: Neighbours) -> None:
        self._place = None
        near = [place for place in peers.parts if self._is_near(place.obstacle, position, peers)]
        if near and self._rng.random() < 0.9:
            wanted = self._rng.choice(near)
            self.held = wanted.obstacle
            self.radius = self._scenario.loaded_radius(self._robot, wanted.part)
            if self._rng.random() < 0.7:  # else it only makes ready to
                self.handles = Handling(wanted.part, self.radius)
        elif peers.parts and self._rng.random() < 0.3:  # from a robot, or out of reach
            part = self._rng.choice(peers.parts).part
            self.radius = self._scenario.loaded_radius(self._robot, part)
            self.handles = Handling(part, self.radius)

    def _is_near(self, obstacle: int, position: Vector, peers: Neighbours) -> bool:
        came = {each.number: each.shape for each in peers.obstacles if each.status == "standing"}
        shape = {**self._scenario.shapes, **came}.get(obstacle)
        if shape is None:
            return False
        return shape.distance(*position) - self._scenario.spec(self._robot).radius <= 2.0 * REACH


def _parts(rng: Random, plain: Scenario) -> tuple[Part, ...]:
    """Up to four, between the robots; at times of one size, beside each other or the wall."""
    found: list[Part] = []
    room, alike, together = plain.workspace.shape, rng.random() < 0.7, rng.random() < 0.7
    for _ in range(60):
        radius = found[0].radius if alike and found else rng.uniform(0.02, 0.07)
        at = rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2)
        if together and found:
            at = _beside(rng, found[-1], radius)
        robots = all(math.dist(at, each.start) > radius + each.radius + 1e-3 for each in plain.robots)
        if robots and room.distance(*at) + radius < 0.0 and _is_apart(at, radius, found):
            found.append(Part(radius, at, at))
    return tuple(found[:4])


def _beside(rng: Random, other: Part, radius: float) -> Vector:
    away, turn = other.radius + radius + 2e-3, rng.uniform(0.0, math.tau)
    return other.start[0] + away * math.cos(turn), other.start[1] + away * math.sin(turn)


def _is_apart(at: Vector, radius: float, others: Sequence[Part]) -> bool:
    return all(math.dist(at, each.start) > radius + each.radius + 1e-3 for each in others)


MUTANTS = (
    without(
        "room-to-grow",
        "a robot takes itself for the larger disk only where that satisfies all that is obeyed",
        Edit(_FILTER, "if not (inside and self.lines.enlarge(radius, part)):", "if not inside:"),
    ),
    without(
        "inside-to-grow",
        "and is inside",
        Edit(_FILTER, "if not (inside and self.lines.enlarge", "if not (self.lines.enlarge"),
    ),
    without(
        "grown-before-asking",
        "it asks for a part only once it keeps the larger disk clear",
        Edit(
            _ROBOT, "return mover.handles if filter_.radius >= mover.radius else None", "return mover.handles"
        ),
    ),
    without(
        "as-large-as-told",
        "it never is a smaller disk than the roster says",
        Edit(_ROBOT, "        radius = max(listed, radius)\n", ""),
        first=24,
    ),
    without(
        "born-large",
        "a later life begins as the disk that its earlier one was",
        Edit(_ROBOT, "        if first and own is not None:", "        if False and own is not None:"),
        first=1900,
    ),
    without(
        "stands-at-its-size",
        "the roster has the size of the disk before any robot learns that it stands",
        Edit(
            _PARTS,
            "self._lives.roster.alter(robot, radius=self._scenario.loaded_radius(robot, place.part))",
            "pass",
        ),
    ),
    without(
        "lines-of-the-larger-disk",
        "half-planes are those of the disk that it is",
        Edit("agents.lines.negotiation", "        self.own_radius = own_radius\n", "        pass\n"),
    ),
)


def test_nothing_touches() -> None:
    handled = 0
    for seed in range(4):
        haul = Haul(seed, Product())
        for _ in range(60):
            haul.tick()
            assert not haul.violation(), seed
        handled += haul.handled
    assert handled > 6


@pytest.mark.campaign
@pytest.mark.timeout(600)
@pytest.mark.parametrize("mutant", [pytest.param(each, id=each.rule) for each in MUTANTS])
def test_without_the_rule_something_touches(mutant: Mutant) -> None:
    product = Product(mutant.edits)
    assert mutant.hunt(lambda seed: violation_of(seed, product), _RUNS)
