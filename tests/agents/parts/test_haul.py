"""Nothing touches while disks grow and shrink; without any one rule for that something does."""

import pytest

from tests.agents.lines.models.product import Product
from tests.agents.parts.haul import Haul, violation_of
from tests.interpreted import Edit, Mutant, without

pytestmark = pytest.mark.slow

_ROBOT, _FILTER, _PARTS = "agents.robot", "agents.safety_filter", "world.coordinator.parts"
_RUNS = 1_000  # random ones in which a mutant has to be found, at most, wherever they begin

MUTANTS = (
    without(
        "room-to-grow",
        "a robot takes itself for the larger disk only where that satisfies all that is obeyed",
        Edit(_FILTER, "if not (inside and self.lines.reach(radius, part)):", "if not inside:"),
    ),
    without(
        "inside-to-grow",
        "and is inside",
        Edit(_FILTER, "if not (inside and self.lines.reach", "if not (self.lines.reach"),
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
        Edit(_ROBOT, "        radius = max(told, radius)\n", ""),
        first=24,
    ),
    without(
        "born-large",
        "a later life begins as the disk that its earlier one was",
        Edit(
            _ROBOT, "        if first and own is not None and own.radius", "        if False and own.radius"
        ),
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
        Edit("agents.lines.negotiation", "            self.own_radius = own_radius\n", "            pass\n"),
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
    assert mutant.hunt(lambda seed: violation_of(seed, product), _RUNS)[1]
