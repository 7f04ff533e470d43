"""What a campaign is: one run from one seed, from which alone everything in the run is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from tests.campaigns.dice import Dice


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


class Mutant(NamedTuple):
    """The product without one of its rules, and the search for what goes wrong then.

    hunt: returns how many runs (or states) it took, and the violation, "" if none was found.
    """

    rule: str
    hunt: Callable[[], tuple[int, str]]


@dataclass(frozen=True)
class Campaign:
    """What the driver has to know of a campaign.

    Attributes:
        run: one run, drawn from the seed of the dice, or by them, so that what it shows can be shrunk; an
            exception is a violation.
        runs: how many there are unless asked for.
        mutants: the product without one rule each; each has to be found.
        patience: s of processor time that one run may take.
        alone: whether a run starts processes of its own; such runs are not made in workers.
    """

    run: Callable[[Dice], Outcome]
    runs: int
    mutants: Callable[[], Sequence[Mutant]] = tuple
    patience: float = 150.0
    alone: bool = False
