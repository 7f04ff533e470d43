"""Waiting for what comes in real time."""

import time
from collections.abc import Callable
from typing import Any

PATIENCE = 30.0  # s


def until(condition: Callable[[], Any], patience: float = PATIENCE, what: str = "waited in vain") -> Any:
    """What comes of a condition, once that is something."""
    deadline = time.monotonic() + patience
    while not (found := condition()):
        assert time.monotonic() < deadline, what
        time.sleep(0.005)
    return found
