"""What a campaign is: one run from one seed, from which alone everything in the run is drawn by dice."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import NamedTuple, TypeVar

T = TypeVar("T")
_STEPS = 10**6  # of a uniform number


class Dice:
    """Choices from a seed."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self._random = Random(seed)

    def whole(self, low: int, high: int) -> int:
        return low + self._random.randint(0, high - low)

    def chance(self, probability: float) -> bool:
        """Whether something of this probability happens."""
        return self.whole(0, _STEPS - 1) >= round((1.0 - probability) * _STEPS)

    def uniform(self, low: float, high: float) -> float:
        return low + (high - low) * (self.whole(0, _STEPS) / _STEPS)

    def log_uniform(self, low: float, high: float) -> float:
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def pick(self, options: Sequence[T]) -> T:
        """One of the options; what occurs twice is twice as likely."""
        return options[self.whole(0, len(options) - 1)]

    def shuffled(self, items: Sequence[T]) -> list[T]:
        left = list(items)
        return [left.pop(self.whole(0, len(left) - 1)) for _ in items]


class Outcome(NamedTuple):
    """What came of one run.

    Attributes:
        said: in a word or two, to be counted; of a violation, what kind it is.
        violation: what must not be; "" if nothing.
        shows: an input that shows the violation.
        figures: measured in it; of each the least, the mean and the most are printed.
    """

    said: str
    violation: str = ""
    shows: str = ""
    figures: Mapping[str, float] = {}


@dataclass(frozen=True)
class Campaign:
    """What the driver has to know of a campaign.

    Attributes:
        run: one run, drawn from the seed of the dice, or by them; an exception is a violation.
        runs: how many there are unless asked for.
        patience: s of processor time that one run may take.
        alone: whether a run starts processes of its own; such runs are not made in workers.
    """

    run: Callable[[Dice], Outcome]
    runs: int
    patience: float = 150.0
    alone: bool = False
