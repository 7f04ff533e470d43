"""What the world's checkpoint costs a tick, and how large its states are.

`added` is the world's own time for it, in turns with a world without one, the least of each; `share` is its
part of a tick of a real fleet without it.

    python -m tests.benchmarks.recording.checkpoint --robots 6 32 200
"""

import argparse
import time
from collections.abc import Sequence
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec

from deploy.run.options import RunOptions
from protocol.messages import Command
from protocol.scenario.model import Scenario
from tests.benchmarks.crowds import measure, restless
from world.shell.checkpoint import Checkpoint, Processes, SavedRun
from world.world import WorldCore

_TICKS, _REPEAT = 64, 40
_SECONDS = 2.0  # s that each fleet is measured


def added(setting: Scenario) -> tuple[float, int]:
    """Time that a checkpoint adds to a tick, s, and bytes of the largest state."""
    without, kept, size = inf, inf, 0
    with TemporaryDirectory(prefix="disknav-") as folder:
        path = Path(folder) / "checkpoint"
        Checkpoint.create(path)
        checkpoint = Checkpoint(path, "local", setting)
        for _ in range(_REPEAT):
            without = min(without, _drive(WorldCore(setting), None))
            world = WorldCore(setting)
            kept = min(kept, _drive(world, checkpoint))
            size = max(size, len(msgspec.msgpack.encode(world.past)))
        checkpoint.remove()
    return kept - without, size


def _drive(world: WorldCore, checkpoint: Checkpoint | None) -> float:
    """Time of a tick, s."""
    robots: Sequence[int] = world.scenario.ids
    for robot in robots:
        world.join(robot)
    processes = Processes(dict.fromkeys(robots, "0123456789abcdef"))
    began = time.perf_counter()
    for _ in range(_TICKS):
        told = world.open_tick()
        if checkpoint is not None:
            checkpoint.write(SavedRun((1,), 0.0, processes, world.past))
        for robot in robots:
            world.accept(Command(robot, told[robot].incarnation, world.tick, (0.001, -0.001)))
        world.close_tick()
    return (time.perf_counter() - began) / _TICKS


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=(6, 32), help="numbers of robots")
    options = parser.parse_args()
    print(f"{'robots':>6}{'bytes':>8}{'added us':>10}{'ticks/s':>10}{'share':>8}")
    for robots in options.robots:
        setting = restless(robots)
        more, size = added(setting)
        rate = measure(setting, RunOptions(), _SECONDS).ticks_per_second
        print(f"{robots:6d}{size:8d}{1e6 * more:10.1f}{rate:10.0f}{more * rate:8.4f}", flush=True)


if __name__ == "__main__":
    main()
