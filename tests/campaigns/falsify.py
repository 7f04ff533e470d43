"""A search for a scenario in which the filter breaks its promise, among all that a scenario can express."""

import time
from collections.abc import Iterator
from functools import partial

from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions, Transport
from protocol.scenario.file import write_toml
from protocol.scenario.model import Scenario
from tests.campaigns.campaign import Campaign, Dice, Outcome
from tests.campaigns.observe import PATIENCE, Observation, Violation, observe, violations
from tests.campaigns.scenarios.draw import drawn

_REPEATED = 0.125  # of the runs, in another order of joining, on a busy machine


def run(dice: Dice, transport: Transport = "local") -> Outcome:
    """One scenario.

    Args:
        transport: it is run on real processes, too, unless this is "local".
    """
    repeated = dice.chance(_REPEATED)
    scenario = drawn(dice)
    if scenario is None:
        return Outcome("refused")
    seen = observe(scenario)
    found = next(violations_of(scenario, seen, transport, repeated=repeated), None)
    if found is not None:
        return Outcome(found.kind, found.text, write_toml(scenario))
    return Outcome(seen.report["verdict"], figures={"ticks": len(scenario.robots) * seen.report["ticks"]})


def run_mortal(dice: Dice) -> Outcome:
    """One scenario whose world dies a few times, at any operation by which it tells what it did."""
    busy = dice.pick((0, dice.seed + 1))
    scenario = drawn(dice)
    if scenario is None:
        return Outcome("refused")
    last = (len(scenario.robots) + 6) * scenario.ticks(scenario.time.limit)
    seen = observe(scenario, busy=busy, deaths=[dice.whole(0, last) for _ in range(dice.whole(1, 6))])
    if found := next(iter(seen.violations), None):
        return Outcome(found.kind, found.text, write_toml(scenario))
    return Outcome(seen.report["verdict"], figures={"deaths": len(seen.report["worlds"])})


def violations_of(
    scenario: Scenario, seen: Observation, transport: Transport, *, repeated: bool
) -> Iterator[Violation]:
    """What is wrong with a run that was observed, in another order of joining, and on real processes."""
    yield from seen.violations
    if repeated:
        other = observe(scenario, joining=scenario.ids[::-1], busy=scenario.seed + 1)
        yield from other.violations
        if other.trajectory != seen.trajectory:
            yield Violation("order", "another trajectory if robots join in the opposite order")
    if transport != "local":
        yield from on_processes(scenario, transport, seen.trajectory)


def on_processes(scenario: Scenario, transport: Transport, trajectory: str) -> Iterator[Violation]:
    """What is wrong with a run on a fleet of its own.

    Args:
        trajectory: digest of the trajectory within one process.
    """
    deadline = time.monotonic() + PATIENCE
    with Fleet(scenario, RunOptions(transport)) as fleet:
        report = fleet.execute(lambda: time.monotonic() > deadline)
    yield from violations(report)
    if report["trajectory_sha256"] != trajectory:
        yield Violation("bus", f"another trajectory on {transport}: {report['verdict']}, {report['reason']}")


LOCAL = Campaign(run, 20_000)
MORTAL = Campaign(run_mortal, 5_000)
ROUTED = Campaign(partial(run, transport="routed"), 200, patience=2.0 * PATIENCE, alone=True)
MESH = Campaign(partial(run, transport="mesh"), 200, patience=2.0 * PATIENCE, alone=True)
