"""Damaged inputs by the million, for everything that reads what others wrote.

Inputs are valid ones, taken from real runs and from the library, with bytes, characters or values changed.
Beyond raising nothing undeclared, what a reader accepts must survive being written and read again.
"""

import traceback
from random import Random
from typing import Any

from tests.campaigns.campaign import Campaign, Dice, Outcome
from tests.campaigns.fuzz.documents import ORDERS, SCENARIOS
from tests.campaigns.fuzz.hosts import HOSTS
from tests.campaigns.fuzz.kept import KEPT
from tests.campaigns.fuzz.messages import JOINING, KEYS, MESSAGES, PARTICIPANTS

TARGETS = {**MESSAGES, **JOINING, **PARTICIPANTS, **KEYS, **SCENARIOS, **ORDERS, **HOSTS, **KEPT}
_SCHEDULE = [name for name, target in TARGETS.items() for _ in range(target.share)]


def target_of(seed: int) -> str:
    """Which reader gets the input of a seed: shares come round in turn."""
    return _SCHEDULE[seed % len(_SCHEDULE)]


def drawn(seed: int) -> Any:
    return TARGETS[target_of(seed)].draw(Random(seed))


def read(dice: Dice) -> Outcome:
    """Have one input read; the violation is any exception that the reader does not declare."""
    name, given = target_of(dice.seed), drawn(dice.seed)
    target = TARGETS[name]
    try:
        target.read(given)
    except target.declared:
        return Outcome(f"{name}, refused")
    except Exception as error:  # noqa: BLE001  any exception is what the campaign searches for
        where = traceback.extract_tb(error.__traceback__)[-1]
        said = f"{name}, {type(error).__name__} at {where.filename}:{where.lineno}"
        return Outcome(said, str(error) or repr(error), f"{given!r}\n\n{traceback.format_exc(limit=-12)}")
    return Outcome(f"{name}, accepted")


FUZZ = Campaign(read, 1_000_000, patience=10.0)
