"""The runs that came nearest to touching: the best of each niche, so that no kind crowds out the others."""

from __future__ import annotations

from dataclasses import dataclass

from deploy.studies.falsify.scenarios.dice import Dice
from protocol.scenario.model import Scenario

_CONTENDERS = 2  # parents that are drawn; the nearer one wins


@dataclass(frozen=True)
class Entry:
    """One near miss."""

    score: float
    number: int
    scenario: Scenario


class Archive:
    """Near misses by niche. Its content depends on what was added only, in the order of adding."""

    def __init__(self) -> None:
        self._best: dict[tuple[str, ...], Entry] = {}

    def __len__(self) -> int:
        return len(self._best)

    def wants(self, niche: tuple[str, ...], score: float) -> bool:
        """Whether nobody in this niche came nearer; of equals the newer, or the search would stand still."""
        held = self._best.get(niche)
        return held is None or score >= held.score

    def add(self, niche: tuple[str, ...], entry: Entry) -> None:
        """Take over a run."""
        self._best[niche] = entry

    def parents(self, dice: Dice) -> tuple[Scenario, Scenario]:
        """One to change, the nearer of some niches, and one to take traits from."""
        entries = list(self._best.values())
        one = max((dice.pick(entries) for _ in range(_CONTENDERS)), key=lambda entry: entry.score)
        return one.scenario, dice.pick(entries).scenario
