"""Runs campaigns: in parallel, within a time; keeps every input that shows a violation."""

from __future__ import annotations

import multiprocessing
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from math import inf
from pathlib import Path

from tests.campaigns.campaign import Campaign, Dice, Outcome
from tests.campaigns.catalogue import find

_BATCH = 64  # runs, at most, that a worker is given at a time
_SAVED = 50  # inputs; more would show nothing new
_DEAD = 600.0  # s without any result after which the workers are taken for dead


@dataclass
class Tally:
    """What came of all runs so far.

    Attributes:
        said: how often what came of it.
        figures: of each the least, the sum and the most.
        violations: by seed.
    """

    runs: int = 0
    said: Counter[str] = field(default_factory=Counter)
    figures: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    violations: dict[int, Outcome] = field(default_factory=dict)

    def add(self, seed: int, outcome: Outcome) -> None:
        self.runs += 1
        self.said[outcome.said] += 1
        if outcome.violation:
            self.violations[seed] = outcome
        for name, value in outcome.figures.items():
            least, total, most = self.figures.get(name, (inf, 0.0, -inf))
            self.figures[name] = (min(least, value), total + value, max(most, value))

    def __str__(self) -> str:
        lines = [f"{self.runs} runs, {len(self.violations)} with a violation"]
        lines += [f"  {said}: {number}" for said, number in sorted(self.said.items())]
        for name, (least, total, most) in sorted(self.figures.items()):
            lines.append(f"  {name}: {least:.4g} to {most:.4g}, {total / self.runs:.4g} a run")
        return "\n".join(lines)


def execute(
    name: str,
    runs: int,
    seed: int,
    *,
    jobs: int,
    minutes: float = inf,
    folder: Path,
    tell: Callable[[str], None],
) -> Tally:
    """Run a campaign; after Ctrl-C, what came of it so far.

    Args:
        runs, seed: from which seed on, and how many.
        minutes: after which no run begins.
        folder: for inputs that show a violation.
        tell: is told each violation.
    """
    tally, until = Tally(), time.monotonic() + 60.0 * minutes
    try:
        batch = max(1, min(_BATCH, runs // (8 * jobs)))
        for number, outcome in outcomes(name, range(seed, seed + runs), jobs, batch, until):
            tally.add(number, outcome)
            if outcome.violation:
                tell(f"seed {number}: {outcome.said}: {outcome.violation}")
                if len(tally.violations) <= _SAVED:
                    save(folder / f"{name}-{number}.txt", outcome)
    except KeyboardInterrupt:
        tell("stopped")
    return tally


def outcomes(
    name: str, seeds: Iterable[int], jobs: int, batch: int = 1, until: float = inf
) -> Iterator[tuple[int, Outcome]]:
    """Seeds and what came of their runs, in any order, until a moment of the monotonic clock (s)."""
    campaign, numbers = find(name), iter(seeds)
    if jobs == 1 or campaign.alone:
        for seed in numbers:
            yield seed, attempt(campaign, Dice(seed))
            if time.monotonic() > until:
                return
        return
    batches = iter(lambda: list(islice(numbers, batch)), [])
    with _pool(jobs) as pool:
        results = pool.imap_unordered(partial(_batch, name), batches)
        while time.monotonic() < until:
            try:
                yield from results.next(batch * campaign.patience + _DEAD)
            except StopIteration:
                return


def attempt(campaign: Campaign, dice: Dice) -> Outcome:
    """One run. An exception, or that it takes too long, is a violation."""
    try:
        with _within(campaign.patience):
            return campaign.run(dice)
    except Exception as error:  # noqa: BLE001  any exception is what the campaign searches for
        place = traceback.extract_tb(error.__traceback__)[-1].name
        text = traceback.format_exc(limit=-12)
        return Outcome(f"{type(error).__name__} in {place}", str(error) or repr(error), text)


def save(path: Path, outcome: Outcome) -> Path:
    """Write what shows a violation, below what it shows."""
    path.parent.mkdir(parents=True, exist_ok=True)
    says = "".join(f"# {line}\n" for line in f"{outcome.said}: {outcome.violation}".splitlines())
    path.write_text(f"{says}\n{outcome.shows}", encoding="utf-8", errors="backslashreplace")
    return path


def _pool(jobs: int) -> multiprocessing.pool.Pool:
    """Leaving it ends the workers, in the middle of a run, too; Ctrl-C is the parent's."""
    return multiprocessing.get_context("spawn").Pool(jobs, signal.signal, (signal.SIGINT, signal.SIG_IGN))


def _batch(name: str, seeds: Sequence[int]) -> list[tuple[int, Outcome]]:
    campaign = find(name)
    return [(seed, attempt(campaign, Dice(seed))) for seed in seeds]


@contextmanager
def _within(seconds: float) -> Iterator[None]:
    """Raises TimeoutError inside after so much processor time; in the main thread only."""

    def late(*_: object) -> None:
        raise TimeoutError(f"more than {seconds:g} s")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
