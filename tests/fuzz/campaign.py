"""A campaign: numbered inputs, each drawn from seed and number alone, and what is found among them."""

from __future__ import annotations

import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from random import Random
from typing import Any

from tests.fuzz.catalogue import TARGETS

PATIENCE = 10.0  # s that reading one input may take
_SCHEDULE = [name for name, target in TARGETS.items() for _ in range(target.share)]


class TooSlowError(Exception):
    """Reading an input took longer than `PATIENCE`."""


@dataclass(frozen=True)
class Finding:
    """An input that brought about what no reader declares."""

    number: int
    target: str
    drawn: Any
    error: str  # traceback

    def __str__(self) -> str:
        return f"input {self.number}, target {self.target}\n{self.drawn!r}\n\n{self.error}"


@dataclass
class Tally:
    """What came of the inputs of a campaign; one finding is kept for each place that raised."""

    accepted: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    slowest: float = 0.0  # s
    findings: dict[tuple[str, str], Finding] = field(default_factory=dict)
    found: int = 0


def target_of(number: int) -> str:
    """Which reader gets an input: shares come round in turn."""
    return _SCHEDULE[number % len(_SCHEDULE)]


def drawn(seed: int, number: int, rng: Random | None = None) -> Any:
    """Input `number` of the campaign with this seed, whatever was drawn before."""
    rng = Random() if rng is None else rng
    rng.seed((seed << 64) + number)
    return TARGETS[target_of(number)].draw(rng)


def campaign(seed: int, numbers: Iterable[int], tell: Callable[[int], None] = lambda _: None) -> Tally:
    """Read every input; `tell` hears how many are done, now and then. Main thread only."""
    tally, rng = Tally(), Random()
    before = signal.signal(signal.SIGALRM, _too_slow)
    try:
        for done, number in enumerate(numbers):
            _try(number, drawn(seed, number, rng), tally)
            if done % 1000 == 0:
                tell(done)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    return tally


def _try(number: int, each: Any, tally: Tally) -> None:
    name = target_of(number)
    target = TARGETS[name]
    began = time.perf_counter()
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        target.read(each)
        tally.accepted[name] += 1
    except target.declared:
        tally.refused[name] += 1
    except Exception as error:  # noqa: BLE001  whatever it is, it is what is looked for
        tally.found += 1
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = type(error).__name__, f"{where.filename}:{where.lineno}"
        text = traceback.format_exc(limit=-12)
        tally.findings.setdefault(place, Finding(number, name, each, text))
    tally.slowest = max(tally.slowest, time.perf_counter() - began)


def _too_slow(*_: object) -> None:
    raise TooSlowError(f"more than {PATIENCE:g} s")
