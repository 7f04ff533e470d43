"""What a worker does with one number of a campaign: a trial, or the shrinking of what a trial showed."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from deploy.library.load import resolved
from deploy.run.options import Transport
from deploy.studies.falsify.runs.nearness import nearness
from deploy.studies.falsify.runs.observe import Observation, observe
from deploy.studies.falsify.runs.on_processes import on_processes
from deploy.studies.falsify.runs.violation import Violation, other_trajectory
from deploy.studies.falsify.scenarios.preceding import preceding
from deploy.studies.falsify.shrinking.shrink import among, shrunk
from deploy.studies.harness.runners.worker import Send
from deploy.studies.harness.study import Run
from protocol.scenario.file import apply_settings, document_of, parse_document, parse_toml, write_toml
from protocol.scenario.model import Scenario

Result = dict[str, Any]
Task = Callable[[Run], Result]
Source = Callable[[int], tuple[Scenario, int]]  # from a number a scenario, and how many draws were refused

# one in so many fresh draws, and mutants, is run again with the robots joining in another order, and another
# one as the second of a run
REPEATED = 8
TRIES: dict[Transport, int] = {"local": 600, "routed": 40, "mesh": 40}  # of one shrinking


@dataclass(frozen=True)
class Trial:
    """Run a scenario, judge it, and say how near it came."""

    source: Source
    settings: tuple[str, ...] = ()

    def scenario(self, number: int) -> tuple[Scenario, int]:
        """What is run, settings laid over it, and how many draws were refused.

        Raises:
            ScenarioError: a setting does not fit the scenario.
        """
        scenario, refused = self.source(number)
        return self._laid_over(scenario), refused

    def first(self, scenario: Scenario, number: int) -> Scenario:
        """What `scenario` follows, on the same robots, settings laid over it.

        Raises:
            ScenarioError: a setting does not fit it.
        """
        return self._laid_over(preceding(scenario, number))

    def _laid_over(self, scenario: Scenario) -> Scenario:
        if not self.settings:
            return scenario
        document = apply_settings(document_of(scenario), self.settings)
        return resolved(parse_document(document, scenario.name))

    def __call__(self, run: Run) -> Result:
        """In plain types; `niche` and `score` are None for what is no near miss but a violation."""
        began = time.monotonic()
        scenario, refused = self.scenario(run.seed)
        turn = run.seed // 2 % REPEATED  # odd numbers are mutants
        repeated = turn == 0
        seen = observe(scenario)
        found = examined(scenario, seen, run.transport, repeated=repeated)
        follows = turn == REPEATED // 2 and seen.report is not None
        first = self.first(scenario, run.seed) if follows else None
        if first is not None:
            found += as_second(first, scenario, seen.trajectory)
        near = None
        if seen.report is not None and not found:
            near = nearness(scenario, seen.truths, seen.sides, seen.report["faults"])
        return {
            "refused": refused,
            "repeated": repeated,
            "follows": follows,
            "violations": [asdict(each) for each in found],
            "scenario": write_toml(scenario) if found else None,
            "first": write_toml(first) if found and first is not None else None,
            "niche": None if near is None else near.niche,
            "score": None if near is None else near.score,
            "verdict": None if seen.report is None else seen.report["verdict"],
            "robot_ticks": 0 if seen.report is None else len(scenario.robots) * seen.report["ticks"],
            "seconds": time.monotonic() - began,
        }


@dataclass(frozen=True)
class Shrinking:
    """Find the smallest scenario that shows one violation of another one.

    Of two that are run on the same robots the second is made smaller, and then the first.
    """

    toml: str
    violation: Violation
    first: str | None = None

    def __call__(self, run: Run) -> Result:
        """The scenario, that before it, what is shown then, and how many were tried."""
        scenario = resolved(parse_toml(self.toml))
        first = None if self.first is None else resolved(parse_toml(self.first))
        shown = self.violation

        def shows(smaller: Scenario, before: Scenario | None) -> bool:
            nonlocal shown
            for each in _looked_for(smaller, self.violation, run.transport, before):
                if each.making == self.violation.making:
                    shown = each
                    return True
            return False

        tries = TRIES[run.transport if self.violation.kind == "bus" else "local"]
        if first is None:
            smallest, tried = shrunk(scenario, lambda smaller: shows(smaller, None), tries)
        else:
            whole = first
            smallest, tried = shrunk(
                scenario, lambda smaller: shows(smaller, among(smaller.ids, whole)), tries // 2
            )
            smallest = resolved(smallest)
            first, more = shrunk(
                among(smallest.ids, whole) or whole, lambda smaller: shows(smallest, smaller), tries // 2
            )
            tried += more
        return {
            "scenario": write_toml(smallest),
            "first": None if first is None else write_toml(first),
            "violation": asdict(shown),
            "tried": tried,
        }


def examined(
    scenario: Scenario, seen: Observation, transport: Transport, *, repeated: bool
) -> list[Violation]:
    """All violations of a run that was seen, in another order and on processes if asked for."""
    found = list(seen.violations)
    if seen.report is not None and repeated:
        found += in_another_order(scenario, seen.trajectory)
    if seen.report is not None and transport != "local":
        found += on_processes(scenario, transport, seen.trajectory)
    return found


def in_another_order(scenario: Scenario, trajectory: str) -> list[Violation]:
    """Whether robots that join in the opposite order, on a busy machine, drive another trajectory."""
    other = observe(scenario, joining=scenario.ids[::-1], busy=scenario.seed + 1)
    if other.report is None:
        return other.violations
    if other.trajectory == trajectory:
        return []
    how = "if robots join in the opposite order, on a busy machine"
    return [other_trajectory("order", trajectory, other.trajectory, how)]


def as_second(first: Scenario, scenario: Scenario, trajectory: str) -> list[Violation]:
    """What is wrong with a run of two scenarios, the second of which drives this trajectory alone."""
    both = observe(scenario, before=[first])
    found = list(both.violations)
    if both.report is not None and both.trajectory != trajectory:
        found.append(other_trajectory("second", trajectory, both.trajectory, f"after {first.name}"))
    return [replace(each, follows=True) for each in found]


def _looked_for(
    scenario: Scenario, violation: Violation, transport: Transport, first: Scenario | None
) -> list[Violation]:
    """Violations of a scenario, as far as one like this may be among them; of two if it is to follow one."""
    if violation.follows and (first is None or first.ids != scenario.ids):
        return []
    seen = observe(scenario)
    if first is not None and violation.follows:
        return as_second(first, scenario, seen.trajectory)
    by_bus = transport if violation.kind == "bus" else "local"
    return examined(scenario, seen, by_bus, repeated=violation.kind == "order")


def perform(batch: Sequence[tuple[Run, Task]], send: Send) -> None:
    """Do what a worker was given, one after the other."""
    for run, task in batch:
        send(run, task(run))
