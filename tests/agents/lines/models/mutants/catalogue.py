"""Rules of the safety protocol. The models have to find a violation without each (`test_mutants`); without
others, of lives and rosters, the proof of the product does (`tests/proof`)."""

from __future__ import annotations

from tests.agents.lines.models.mutants.far import AFTERWARDS, FAR
from tests.agents.lines.models.mutants.itself import ITSELF
from tests.agents.lines.models.mutants.pair import PAIR
from tests.agents.lines.models.mutants.surroundings import SURROUNDINGS

MUTANTS = (*PAIR, *ITSELF, *SURROUNDINGS, *FAR, *AFTERWARDS)
