"""What the world's journal costs a fleet, and how fast it is replayed.

Rates are ticks per second of real fleets, with and without, in turns; the ratio is the median over the
rounds. On a busy machine it says little; `added` is then what counts, the world's own time for the journal,
and `share` its part of a tick without it. Replayed is the journal that a run in this process left.

    python -m tests.benchmarks.recording.journal --robots 6 32 --rounds 9
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple
from unittest.mock import patch

from deploy.run.local import LocalFleet
from protocol.messages import Command
from tests.benchmarks.fleets import measure, scenario
from world.judge import trajectory
from world.shell.persistence.journal import Journal
from world.shell.persistence.replay import resume
from world.shell.persistence.snapshot import frozen, thawed
from world.world import World

_TICKS = 64
_LIMIT = 15.0  # s, simulated, of a run that is replayed


class Cost(NamedTuple):
    """Median rates, and the median of their ratios."""

    plain: float
    journalled: float
    ratio: float


def cost(robots: int, seconds: float, rounds: int) -> Cost:
    """Both in turns, either first as often as the other."""
    pairs = []
    for number in range(rounds):
        order = (0, 1) if number % 2 else (1, 0)
        measured = {restarts: measure(robots, seconds, restarts=restarts) for restarts in order}
        pairs.append((measured[0], measured[1]))
    return Cost(
        median(plain.ticks_per_second for plain, _ in pairs),
        median(kept.ticks_per_second for _, kept in pairs),
        median(kept.ticks_per_second / plain.ticks_per_second for plain, kept in pairs),
    )


def added(robots: int, repeat: int = 60) -> float:
    """What the journal adds to the world's own work in a tick, µs: the least of both, in turns."""
    setting = scenario(robots)
    without, kept = inf, inf
    with TemporaryDirectory(prefix="disknav-") as folder:
        for number in range(repeat):
            path = Path(folder) / str(number)
            Journal.create(path, "local", setting)
            journal = Journal(path, "local", setting)
            without = min(without, _drive(World(setting), setting.ids))
            kept = min(kept, _drive(resume(journal, setting).run.world, setting.ids))
            journal.remove()
    return 1e6 * (kept - without)


def _drive(world: World, robots: Sequence[int]) -> float:
    """Time of a tick, s."""
    for robot in robots:
        world.coordinator.join(robot)
    began = time.perf_counter()
    for _ in range(_TICKS):
        told = world.open_tick()
        for robot in robots:
            world.accept(Command(robot, told[robot].incarnation, world.tick, (0.001, -0.001)))
        world.close_tick()
    return (time.perf_counter() - began) / _TICKS


class Replay(NamedTuple):
    """Bytes a tick, ticks a second, simulated seconds a second, and s for all that can follow a snapshot."""

    size: float
    speed: float
    times_real: float
    longest: float


def replay(robots: int) -> Replay:
    """Of the journal of a whole run."""
    setting = scenario(robots)
    setting = replace(setting, time=replace(setting.time, limit=_LIMIT, endless=False), orders=())
    with TemporaryDirectory(prefix="disknav-") as folder:
        path = Path(folder) / "journal"
        Journal.create(path, "local", setting)
        fleet = LocalFleet(setting, journal=path)
        fleet.execute()
        fleet.kill_world()
        began = time.perf_counter()
        world = resume(Journal(path, "local", setting), setting).run.world
        speed = world.tick / (time.perf_counter() - began)
        size = path.stat().st_size / world.tick
    return Replay(size, speed, speed * setting.time.step, trajectory.LINK / speed)


class Written(NamedTuple):
    """Bytes of a snapshot, and how long it takes to take one and to read it, s."""

    size: int
    taken: float
    read: float


def written(robots: int) -> Written:
    """Of a run that is under way."""
    with patch.object(trajectory, "LINK", _TICKS):
        fleet = LocalFleet(scenario(robots))
        while fleet.world.world.tick < _TICKS:
            fleet.step()
        began = time.perf_counter()
        state = frozen(fleet.world.world)
        taken = time.perf_counter()
        thawed(state)
        return Written(len(state), taken - began, time.perf_counter() - taken)


def main() -> None:
    """Print two tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=(6, 32), help="numbers of robots")
    parser.add_argument("--seconds", type=float, default=2.0, help="how long each fleet is measured")
    parser.add_argument("--rounds", type=int, default=9)
    options = parser.parse_args()
    print(
        f"{'robots':>6}{'bytes/tick':>12}{'replayed/s':>12}{'x real':>8}{'most s':>8}"
        f"{'snapshot':>10}{'taken ms':>10}{'read ms':>9}"
    )
    for robots in options.robots:
        again, kept = replay(robots), written(robots)
        print(
            f"{robots:6d}{again.size:12.0f}{again.speed:12.0f}{again.times_real:8.0f}{again.longest:8.1f}"
            f"{kept.size:10d}{1e3 * kept.taken:10.2f}{1e3 * kept.read:9.2f}",
            flush=True,
        )
    print(f"{'robots':>6}{'ticks/s':>12}{'with it':>12}{'ratio':>8}{'added us':>11}{'share':>8}")
    for robots in options.robots:
        own, more = cost(robots, options.seconds, options.rounds), added(robots)
        print(
            f"{robots:6d}{own.plain:12.0f}{own.journalled:12.0f}{own.ratio:8.3f}"
            f"{more:11.1f}{more * 1e-6 * own.plain:8.4f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
