"""Where and before whom the system runs the processes of a fleet: on one core, or with real-time priority."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from protocol.errors import UsageError
from protocol.process.log import LOG

_LEAST = 2  # robots for each core
_PRIORITY = 1  # the least that there is, and before all that has none


class Scheduling(NamedTuple):
    """How a process is scheduled, and all threads and processes that it starts; as the system likes unless
    something else is said.

    core: number of the processor core that it stays on.
    realtime: it runs before everything without real-time priority, and takes turns with its like (SCHED_RR).
    """

    core: int | None = None
    realtime: bool = False

    def apply(self) -> None:
        """Have this process, which has one thread yet, be scheduled so; Linux only.

        Raises:
            UsageError: the system refuses real-time priority.
        """
        if self.realtime:
            _take_turns()
        if self.core is not None:
            try:
                os.sched_setaffinity(0, {self.core})
            except OSError as error:  # a sandbox may refuse it, a container lose the core: then it is slower
                LOG.info(f"does not stay on core {self.core}: {error}")


ORDINARY = Scheduling()


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


def require_realtime() -> None:
    """Find out whether processes may have real-time priority here; this one stays as it is.

    Raises:
        UsageError: they may not.
    """
    with ThreadPoolExecutor(1) as apart:  # each thread has its own priority
        apart.submit(_take_turns).result()


def _take_turns() -> None:
    """Give this thread real-time priority.

    Without it a fair scheduler lets robots that have to compute at once wait behind each other on one core
    while another has become idle. What has real-time priority is moved there at once.
    """
    if sys.platform != "linux":
        raise UsageError("--realtime-priority is for Linux only: leave it out")
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_PRIORITY))
    except OSError as error:
        raise UsageError(
            f"--realtime-priority: the system refuses real-time priority {_PRIORITY} ({error.strerror}): "
            f"`ulimit -r` must say {_PRIORITY}, for a login by `rtprio` in /etc/security/limits.conf, in a "
            f"systemd unit by LimitRTPRIO={_PRIORITY}, in a container by --ulimit rtprio={_PRIORITY} or "
            f"--cap-add SYS_NICE; or leave the option out"
        ) from error
