"""Where the robots of a fleet compute that runs as fast as it can."""

from __future__ import annotations

import os
import sys

_LEAST = 2  # robots for each core


def core_of(turn: int, robots: int) -> int | None:
    """The processor core that a robot's process is to stay on, None where the system had better choose.

    The threads of a robot take turns, and so do robots that wait for each other: left to itself the system
    moves them to whichever core is idle, away from what the other core's cache holds of them. On two cores
    beside other work a tick of 16 and 32 robots takes 0.85 of the time so; with 64 on a quiet machine there
    was no difference (`python -m tests.benchmarks`).

    Args:
        turn: how many robots of the fleet come before this one.
        robots: how many there are.
    """
    if sys.platform != "linux":
        return None
    cores = sorted(os.sched_getaffinity(0))
    return cores[turn % len(cores)] if robots >= _LEAST * len(cores) else None
