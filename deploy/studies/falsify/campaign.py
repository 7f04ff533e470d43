"""A campaign: generations of fresh draws and of mutants of what came near, and what they showed.

Parents are chosen between generations only, so that what is run depends on the seed alone: not on the
number of workers, nor on where a campaign that was stopped went on.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice

from deploy.run.options import Transport
from deploy.studies.falsify.archive import Archive, Entry
from deploy.studies.falsify.runs.violation import Violation
from deploy.studies.falsify.scenarios.dice import Dice
from deploy.studies.falsify.scenarios.draw import drawn
from deploy.studies.falsify.scenarios.mutate import mutated
from deploy.studies.falsify.trial import Result, Shrinking, Task, Trial
from deploy.studies.harness.runners.cluster import Cluster
from deploy.studies.harness.runners.run_log import RunLog
from deploy.studies.harness.runners.worker_pool import WorkerPool
from deploy.studies.harness.study import Run

GENERATION = 256
FRESH, MUTANT, SHRINKING = range(3)  # cells of the study
SHRUNK = 5  # violations of one making that are shrunk; further ones are kept as they were drawn
_BATCH = 8
_STREAM = 3


Workers = WorkerPool | Cluster


@dataclass(frozen=True)
class Plan:
    """What a campaign is.

    Attributes:
        seed: of all that is drawn.
        runs: how many scenarios.
        transport: what they run on besides this process.
        settings: `path.to.key=VALUE`, laid over each scenario.
        code: digest of the software; results of another one are not reused.
    """

    seed: int
    runs: int
    transport: Transport
    settings: tuple[str, ...] = ()
    code: str = ""

    def run(self, cell: int, number: int, what: str = "") -> Run:
        """One run of this campaign; how many are asked for makes no difference to the key of its result."""
        campaign = repr((self.seed, self.transport, self.settings, self.code, GENERATION))
        digest = hashlib.sha256(campaign.encode()).hexdigest()[:16]
        return Run(cell, number, self.transport, f"falsify/{digest}/{number}{what}")


@dataclass
class Finding:
    """A violation, and what shows it.

    Attributes:
        scenario: TOML.
        tried: how many were tried to shrink it; 0: not shrunk.
        first: what is run before it on the same robots, TOML; None if it shows the violation alone.
    """

    seed: int
    number: int
    violation: Violation
    scenario: str
    tried: int = 0
    first: str | None = None


@dataclass
class Campaign:
    """Runs a plan, and knows what came of it so far.

    Attributes:
        results: by cell and number.
        findings: every violation.
        told: hears each finding when it is made, and again when it is shrunk.
    """

    plan: Plan
    log: RunLog
    told: Callable[[Finding], None] = lambda _: None
    results: dict[tuple[int, int], Result] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    archive: Archive = field(default_factory=Archive)
    _made: Counter[tuple[str, str]] = field(default_factory=Counter)

    def execute(self, workers: Workers, advance: Callable[[str], None] = lambda _: None) -> None:
        """Run what the log does not know; whatever ends this early, what is known is in the attributes."""
        numbers = iter(range(self.plan.runs))
        while generation := list(islice(numbers, GENERATION)):
            tasks = [self._trial(number) for number in generation]
            found: list[Finding] = []
            for run, result in self._done(tasks, workers):
                self.results[run.cell, run.seed] = result
                found += self._findings(run, result)
                advance(f"{len(self.findings)} found")
            self._keep_near(tasks)
            self._shrink(found, workers)

    def _trial(self, number: int) -> tuple[Run, Trial]:
        """Odd numbers are mutants, once there is something to mutate."""
        plan = self.plan
        if number % 2 == 0 or not self.archive:
            return plan.run(FRESH, number), Trial(partial(drawn, plan.seed), plan.settings)
        one, other = self.archive.parents(Dice(plan.seed, number, _STREAM))
        return plan.run(MUTANT, number), Trial(partial(mutated, one, other, plan.seed), plan.settings)

    def _done(
        self, tasks: Sequence[tuple[Run, Task]], workers: Workers, size: int = _BATCH
    ) -> Iterator[tuple[Run, Result]]:
        """Results of all tasks: those known from before, then the others as they come."""
        left = []
        for run, task in tasks:
            if run.key in self.log.known:
                yield run, self.log.known[run.key]
            else:
                left.append((run, task))
        size = size if self.plan.transport == "local" else 1
        for run, result in workers.run([left[n : n + size] for n in range(0, len(left), size)]):
            self.log.add(run.key, result)
            yield run, result

    def _findings(self, run: Run, result: Result) -> list[Finding]:
        found = [
            Finding(
                self.plan.seed,
                run.seed,
                Violation(**each),
                result["scenario"],
                first=result["first"] if each["follows"] else None,
            )
            for each in result["violations"]
        ]
        self.findings += found
        for finding in found:
            self.told(finding)
        return found

    def _keep_near(self, tasks: Sequence[tuple[Run, Trial]]) -> None:
        """Enter near misses into the archive, in the order of their numbers."""
        for run, trial in tasks:
            result = self.results[run.cell, run.seed]
            if result["score"] is not None:
                niche = tuple(result["niche"])
                if self.archive.wants(niche, result["score"]):
                    scenario, _ = trial.scenario(run.seed)
                    self.archive.add(niche, Entry(result["score"], run.seed, scenario))

    def _shrink(self, found: list[Finding], workers: Workers) -> None:
        """Shrink the first few of each making."""
        due: dict[str, Finding] = {}
        tasks: list[tuple[Run, Task]] = []
        for finding in sorted(found, key=lambda finding: finding.number):
            making = finding.violation.making
            self._made[making] += 1
            if self._made[making] <= SHRUNK:
                run = self.plan.run(SHRINKING, finding.number, f"/{'/'.join(making)}")
                due[run.key] = finding
                tasks.append((run, Shrinking(finding.scenario, finding.violation, finding.first)))
        for run, result in self._done(tasks, workers, size=1):
            finding = due[run.key]
            finding.scenario, finding.tried = result["scenario"], result["tried"]
            finding.first = result["first"]
            finding.violation = Violation(**result["violation"])
            self.told(finding)
