"""Random choices of the kinds that scenarios need, all from one key."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

from protocol.draws import Purpose, generator

T = TypeVar("T")


class Dice:
    """What is drawn for one number of a campaign; `stream` tells its purposes apart."""

    def __init__(self, seed: int, number: int, stream: int) -> None:
        self._random = generator(seed, Purpose.STUDY, stream, number)

    def chance(self, probability: float) -> bool:
        """Whether something of this probability happens."""
        return bool(self._random.random() < probability)

    def uniform(self, low: float, high: float) -> float:
        """A number from [low, high)."""
        return low + (high - low) * float(self._random.random())

    def log_uniform(self, low: float, high: float) -> float:
        """A positive number whose logarithm is uniform."""
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def whole(self, low: int, high: int) -> int:
        """A whole number from low to high, both included."""
        return int(self._random.integers(low, high, endpoint=True))

    def pick(self, options: Sequence[T]) -> T:
        """One of the options; one that stands there twice is twice as likely."""
        return options[int(self._random.integers(len(options)))]

    def shuffled(self, items: Sequence[T]) -> list[T]:
        """The items in a random order."""
        return [items[int(place)] for place in self._random.permutation(len(items))]
