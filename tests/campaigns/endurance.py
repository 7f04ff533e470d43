"""Fleets that never rest: what their processes hold on to, and whether the fleet survives their deaths.

One run is 16 robots on real processes at 20 Hz, which change places over and over for ten minutes. In every
other run a process is killed each half minute, by lot a robot, the router or the world. Judged: nothing
touches; without kills no command is missed; with them every process is started again, all robots command
again within 3 s of every death, and none is down at the end; memory that no file backs, file handles and
threads of a process that lives for long do not grow.
"""

import os
import signal
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from random import Random
from statistics import linear_regression
from typing import NamedTuple

import psutil

from deploy.library.encounters import swap
from deploy.library.load import resolved
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import ENOUGH, Fleet
from deploy.run.options import RunOptions
from protocol.messages import Clock
from protocol.scenario.model import Scenario
from tests.benchmarks.crowds import patrols
from tests.campaigns.campaign import Campaign, Dice, Outcome

ROBOTS, SECONDS, KILL_EVERY = 16, 600.0, 30.0
AGAIN = 3.0  # s
RISE = 0.5  # MB (2^20 bytes) in the second half of a life
FEWEST = 60  # samples of a life that is judged
_PERIOD = 2.0  # s between samples
_LAUNCHER = "launcher"


class Sample(NamedTuple):
    time: float  # s
    memory: float  # MB, resident and not backed by a file
    handles: int
    threads: int


def patrol(robots: int) -> Scenario:
    """A swap on a circle, and back, without end."""
    base = resolved(swap(robots))
    return replace(
        base,
        control=replace(base.control, speed=0.05),
        time=replace(base.time, limit=86_400.0, deadlock=3600.0),
        orders=patrols({each.id: (each.goal, each.start) for each in base.robots}),
    )


class Deaths:
    """Processes of a fleet that were killed, and how long all robots then took until they commanded again."""

    def __init__(self, robots: int) -> None:
        self.names: list[str] = []
        self.longest = 0.0  # s, from a death until a later tick with all robots
        self._robots, self._tick, self._began = robots, 0, 0.0
        self._all_command = True

    def kill(self, supervisor: Supervisor, name: str) -> None:
        supervisor.signal(name, signal.SIGKILL)
        self.names.append(name)
        self._all_command, self._began = False, time.monotonic()

    def follow(self, clock: Clock, restarts: int) -> None:
        """Note a Clock, after so many restarts."""
        again = clock.tick > self._tick and len(clock.active) == self._robots and restarts >= len(self.names)
        self._tick = max(self._tick, clock.tick)
        if not self._all_command:
            self.longest = max(self.longest, time.monotonic() - self._began)
            self._all_command = again


def run(
    dice: Dice, robots: int = ROBOTS, seconds: float = SECONDS, kill_every: float = KILL_EVERY
) -> Outcome:
    """One run; the violation is the first claim that does not hold."""
    kills = dice.seed % 2 == 1
    lives: defaultdict[tuple[str, int], list[Sample]] = defaultdict(list)
    deaths, options = Deaths(robots), RunOptions(mode="realtime", restarts=9999)

    def restarts() -> int:
        return sum(row.restarts for row in fleet.supervisor.usage())

    with Fleet(patrol(robots), options, watch=lambda clock: deaths.follow(clock, restarts())) as fleet:
        began, random = time.monotonic(), Random(dice.seed)

        def enough() -> bool:
            now = time.monotonic() - began
            rows = [row for row in fleet.supervisor.usage() if row.exit_code is None and row.pid]
            pids = {_LAUNCHER: os.getpid()} | {row.name: row.pid for row in rows}
            if now >= _PERIOD * sum(len(life) for (name, _), life in lives.items() if name == _LAUNCHER):
                for name, pid in pids.items():
                    lives[name, pid] += _sampled(pid, now)
            if kills and now >= kill_every * (len(deaths.names) + 1) and now < seconds - kill_every:
                deaths.kill(fleet.supervisor, random.choice(sorted(pids.keys() - {_LAUNCHER})))
            return now >= seconds

        report = fleet.execute(enough)
    faults = (
        (report["collisions"] > 0, f"{report['collisions']} collisions"),
        (report["reason"] != ENOUGH, f"ended early: {report['verdict']}, {report['reason']}"),
        (not kills and report["missed_commands"] > 0, f"{report['missed_commands']} missed commands"),
        (restarts() < len(deaths.names), f"{restarts()} restarts after {len(deaths.names)} kills"),
        (deaths.longest > AGAIN, f"all robots command only {deaths.longest:.1f} s after a death"),
        (bool(report["down"]), f"robots {report['down']} are down at the end"),
        *((True, f"{name}: {growth}") for (name, _), life in lives.items() if (growth := grown(life))),
    )
    memory = sum(life[-1].memory for life in lives.values() if life)
    figures = {
        "ticks": report["ticks"],
        "kills": len(deaths.names),
        "until all command again, s": deaths.longest,
        "memory, MB": memory,
    }
    said = "killed" if kills else "undisturbed"
    return Outcome(said, next((text for fault, text in faults if fault), ""), figures=figures)


def grown(life: Sequence[Sample]) -> str:
    """What grows in a long life; "" if nothing, or the life is short.

    A straight line through the memory of its second half may rise by `RISE`; handles and threads may not be
    more in all samples of the last quarter than in any of the second, for some come and go.
    """
    if len(life) < FEWEST:
        return ""
    half, quarter = life[len(life) // 2 :], len(life) // 4
    line = linear_regression([each.time for each in half], [each.memory for each in half])
    rise = line.slope * (half[-1].time - half[0].time)
    if rise > RISE:
        return f"memory rises by {rise:.2f} MB"
    for what in ("handles", "threads"):
        counts = [getattr(each, what) for each in life]
        if min(counts[-quarter:]) > max(counts[quarter : 2 * quarter]):
            return f"{what} from {max(counts[quarter : 2 * quarter])} to {min(counts[-quarter:])}"
    return ""


def _sampled(pid: int, now: float) -> list[Sample]:
    try:
        process = psutil.Process(pid)
        memory = process.memory_info()
        return [Sample(now, (memory.rss - memory.shared) / 2**20, process.num_fds(), process.num_threads())]
    except psutil.Error:
        return []


ENDURANCE = Campaign(run, 6, patience=2.0 * SECONDS, alone=True)
