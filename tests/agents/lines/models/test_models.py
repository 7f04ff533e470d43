"""Whatever is lost, late or repeated, and whichever disk dies, appears or is taken away, none touch; without
any one rule some do. The campaigns `skirmish` and `aftermath` go on for longer.

Without each rule of the kernel the proof finds a counterexample (`tests/proof`).
"""

from types import ModuleType

import pytest

from tests.agents.lines.models.product import LARGE_ROOM, Product
from tests.agents.lines.models.skirmishes import aftermath, skirmish
from tests.interpreted import Edit, Mutant, without

_RUNS = 2_000  # random ones in which a mutant has to be found, at most, wherever they begin
MODELS = {"skirmish": skirmish, "aftermath": aftermath}

_BOUNDARY = "agents.lines.boundary"
_EXCHANGE = "world.coordinator.exchange"
_ESTIMATE = "agents.estimate"
_FILTER = "agents.safety_filter"
_HEARING = "agents.peers.neighbours"
_LINES = "agents.lines.separating_lines"
_LIVES = "world.coordinator.lives"
_OWN_SET = "agents.lines.own_set"
_PLANT = "world.plants.integrator"
_ROBOT = "agents.robot"
_NEGOTIATION = "agents.lines.negotiation"

MUTANTS = (
    without(
        "settled-commands",
        "lines are taken over only while no command is under way",
        Edit(_HEARING, "if self.is_open and tick <= self._tick and self._link.ideal", "if self._link.ideal"),
        first=340,
    ),
    without(
        "own-error-at-lines",
        "every place where the own centre can be keeps to the lines, not the most likely one",
        Edit(
            _OWN_SET, "return self.bound if self.shape is None else self.shape.extent(nx, ny)", "return 0.0"
        ),
    ),
    without(
        "own-error-at-the-wall",
        "and to the wall",
        Edit(
            _BOUNDARY,
            "if math.hypot(x + dx, y + dy) + shape.radius + extra <= rim:",
            "if math.hypot(x + dx, y + dy) + extra <= rim:",
        ),
    ),
    without(
        "actuation-error",
        "a command leaves room for the stated error of its execution",
        Edit("agents.bodies", "noise=self._noise)", "noise=0.0)"),
    ),
    without(
        "missed-odometry",
        "a tick whose odometry was missed may have led as far as any",
        Edit(_ESTIMATE, "self._widen(self._max_step)", "pass"),
        Edit(
            _ESTIMATE,
            "self._history.append(Disk(0.0, 0.0, self._max_step))",
            "self._history.append(Disk(0.0, 0.0, 0.0))",
        ),
    ),
    without(
        "measured-then",
        "a measurement is of the tick that its stamp names",
        Edit(_ESTIMATE, "for back in range(-age, 0):", "for back in ():"),
    ),
    without(
        "command-of-this-tick",
        "a command counts only in the tick that it names",
        Edit(_EXCHANGE, "if command.tick != self.tick or self.ticks is None:", "if self.ticks is None:"),
    ),
    without(
        "watchdog",
        "a robot whose command is missing stands still",
        Edit(
            _PLANT,
            "            velocity = commands.get(robot)\n",
            "            velocity = self.last[robot] = commands.get(robot, self.last.get(robot))\n",
        ),
        Edit(
            _PLANT,
            "        self.set_fleet(scenario)\n",
            "        self.set_fleet(scenario)\n        self.last: dict[int, Vector] = {}\n",
        ),
    ),
    without(
        "fenced-never-moves",
        "no command of a life is executed after it was announced as standing",
        Edit(
            _EXCHANGE,
            "        if life.fenced or self._lives.refuses(command):\n"
            '            return "fenced" if life.fenced else "ledger"\n',
            '        if self._lives.refuses(command):\n            return "ledger"\n',
        ),
        Edit(
            _LIVES,
            "            if life.status is LifeStatus.UP:\n"
            "                life.status = LifeStatus.LOST\n"
            "\n"
            "    def listeners",
            "\n    def listeners",
        ),
        Edit(
            _ROBOT,
            'return member.incarnation > self.incarnation or member.status != "live"',
            "return member.incarnation > self.incarnation",
        ),
    ),
    without(
        "no-region-no-motion",
        "a robot moves only once it obeys a region",
        Edit(_LINES, "return self.kernel is not None and self.kernel.region is not None", "return True"),
    ),
    without(
        "stay-in-region",
        "a robot stays in its region",
        *LARGE_ROOM,
        Edit(_FILTER, "        if region is None:\n", "        if True:\n"),
    ),
    without(
        "own-error-at-lines-one-by-one",
        "every place where the own centre can be keeps clear of what stands",
        Edit(_LINES, "found.append(own.kept_in(side.nx, side.ny, side.limit))", "found.append(side)"),
    ),
    without(
        "own-error-at-straight-walls",
        "and of straight walls",
        Edit(_BOUNDARY, "wall.slack(x, y) - extent - 2.0 * ROUNDING", "wall.slack(x, y)"),
    ),
    without(
        "nearest-point",
        "a tangent touches the obstacle itself: one through its middle leaves half of it on the own side",
        Edit(_NEGOTIATION, "edge = -target.support(-nx, -ny)", "edge = nx * around.x + ny * around.y"),
        Edit(_OWN_SET, "return is_beside(place.shape, line, low)", "return True"),
    ),
    without(
        "say-firsts-again",
        "a first line is said until the ledger tells it",
        Edit(
            _LINES,
            "        return tuple([bond.first for bond in self._each if bond.first is not None][:FIRSTS])",
            "        found = tuple([bond.first for bond in self._each if bond.first is not None])\n"
            "        for bond in self._each:\n            bond.first = None\n        return found",
        ),
        model="aftermath",
    ),
)


@pytest.mark.parametrize(
    ("model", "edits", "seeds"),
    [
        pytest.param(skirmish, (), range(10), id="no touch"),
        pytest.param(aftermath, (), range(4), id="all become ready"),
        pytest.param(skirmish, LARGE_ROOM, range(1, 41, 5), id="no touch, small regions"),
        pytest.param(aftermath, LARGE_ROOM, range(4, 24, 5), id="all become ready, small regions"),
    ],
)
@pytest.mark.slow
@pytest.mark.timeout(300)
def test_no_run_violates_anything(model: ModuleType, edits: tuple[object, ...], seeds: range) -> None:
    product = Product(edits)  # type: ignore[arg-type]
    assert [seed for seed in seeds if model.violation_of(seed, product)] == []


@pytest.mark.campaign
@pytest.mark.timeout(600)
@pytest.mark.parametrize("mutant", [pytest.param(each, id=each.rule) for each in MUTANTS])
def test_without_the_rule_something_goes_wrong(mutant: Mutant) -> None:
    product = Product(mutant.edits)
    assert mutant.hunt(lambda seed: MODELS[mutant.model].violation_of(seed, product), _RUNS)
