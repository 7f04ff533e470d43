"""Every rule of the safety protocol. The models have to find a violation without each (`test_mutants`)."""

from __future__ import annotations

from tests.agents.lines.models.mutants.far import AFTERWARDS, FAR
from tests.agents.lines.models.mutants.itself import ITSELF
from tests.agents.lines.models.mutants.lives import LIVES
from tests.agents.lines.models.mutants.pair import PAIR
from tests.agents.lines.models.mutants.surroundings import SURROUNDINGS
from tests.agents.lines.models.mutants.who_is_there import WHO_IS_THERE

MUTANTS = (*PAIR, *LIVES, *WHO_IS_THERE, *ITSELF, *SURROUNDINGS, *FAR, *AFTERWARDS)
