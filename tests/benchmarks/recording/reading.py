"""What it takes to read a long recording: peak memory and processor time of the commands that read one.

The recording is made of a short run in this process, over and over at later ticks: by default half an hour of
16 robots at 20 Hz, as the product would have written it.

    python -m tests.benchmarks.recording.reading --minutes 30 --robots 16
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from msgspec.structs import replace

from deploy.library.load import load
from deploy.run.local import LocalFleet
from deploy.telemetry.recording.reader import read
from deploy.telemetry.recording.writer import RecordingFile
from protocol.codec import encode
from protocol.scenario.model import Scenario

COMMANDS = (("info",), ("plot", "-o", "plot.png"), ("replay",), ("replay", "--zenoh", "--speed", "0"))
LIMIT_MB = 200.0
_TICKS = 200  # of the short run


class Cost(NamedTuple):
    """Of one command: peak resident memory, MB, and processor time, s."""

    peak_mb: float
    cpu_s: float


def scenario(robots: int) -> Scenario:
    """Robots that see and hear late, at 20 Hz, so that everything there is gets drawn."""
    settings = ["time.step=0.05", f"time.limit={0.05 * _TICKS}", "link.delay=0.2", "control.speed=0.01"]
    return load(f"swap-{robots}", settings)


def make(path: Path, seconds: float, robots: int) -> int:
    """Write a recording of so many simulated seconds; returns the number of its messages."""
    short = path.with_stem("short")
    with LocalFleet(scenario(robots), "long", record=short) as fleet:
        fleet.execute()
    said = [(entry.key, entry.message) for entry in read(short).entries]
    file, last = RecordingFile(path, "long", scenario(robots)), round(seconds / 0.05)
    for begin in range(0, last, _TICKS):
        later = [(key, replace(each, tick=each.tick + begin)) for key, each in said if each.tick < _TICKS]
        file.write([(key, encode(each)) for key, each in later])
    file.finish()
    return read(path).counts.total()


def cost(path: Path, command: tuple[str, ...]) -> Cost:
    """Run a command of `disknav` on a recording.

    Raises:
        RuntimeError: it failed.
    """
    name, *options = command
    call = [sys.executable, "-m", "disknav", "recording", name, str(path), *options]
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    pid = os.posix_spawn(sys.executable, call, os.environ, file_actions=quiet)
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        raise RuntimeError(f"{' '.join(call)}: exit status {os.waitstatus_to_exitcode(status)}")
    return Cost(usage.ru_maxrss / 2**10, usage.ru_utime + usage.ru_stime)


def main() -> None:
    """Print a line a command; exit status 1 if one takes more than its limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--robots", type=int, default=16)
    options = parser.parse_args()
    with TemporaryDirectory(prefix="disknav-") as folder:
        os.chdir(folder)
        path = Path("long.mcap")
        count = make(path, 60.0 * options.minutes, options.robots)
        print(f"{count} messages, {path.stat().st_size / 2**20:.0f} MB")
        print(f"{'':<30}{'peak MB':>8}{'cpu s':>8}   (at most {LIMIT_MB:g} MB)", flush=True)
        worst = 0.0
        for command in COMMANDS:
            found = cost(path, command)
            worst = max(worst, found.peak_mb)
            print(f"{' '.join(command):<30}{found.peak_mb:>8.0f}{found.cpu_s:>8.1f}", flush=True)
    raise SystemExit(worst > LIMIT_MB)


if __name__ == "__main__":
    main()
