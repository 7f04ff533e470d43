"""Signals at random moments of real processes leave a result, a recording, 130 or 143, and nothing else."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from tests.deploy.processes.ports import free_ports
from tests.scripts import ended
from tests.system.signals.moments import TRANSPORTS, Victim, fresh_name, interrupted, life, minds

pytestmark = [pytest.mark.process, pytest.mark.timeout(150)]


def _later(seed: int) -> Any:
    return pytest.param(seed, marks=pytest.mark.campaign)


@pytest.fixture
def folder() -> Iterator[Path]:
    """Short enough for the names of sockets."""
    with TemporaryDirectory(prefix="m-") as name:
        yield Path(name)


@cache
def span(transport: str) -> float:
    with TemporaryDirectory(prefix="m-") as name:
        return life(Path(name), transport)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*range(2), *map(_later, range(2, 200))])
def test_a_run_that_is_interrupted_leaves_what_is_promised(seed: int, folder: Path) -> None:
    transport = TRANSPORTS[seed % len(TRANSPORTS)]
    outcome = interrupted(folder, seed, span(transport), transport)
    assert outcome.faults == [], f"seed {seed}"


@pytest.mark.parametrize("seed", [0, *map(_later, range(1, 50))])
def test_single_processes_end_whatever_they_are_doing(seed: int, folder: Path) -> None:
    """Alone and in a run, which may not have begun, and whose router or world may have ended before them."""
    dice = Random(seed)
    (port,) = free_ports(1)
    run, endpoint = fresh_name(), f"tcp/127.0.0.1:{port}"
    here = ("--router", endpoint, "--run", run)
    commands = [
        ("node", "router", "--listen", endpoint),
        ("node", "world", "swap-2", "--mode", "realtime", "--set", "control.speed=0.01", *here),
        ("node", "robot", "1", *here),
        ("node", "robot", "2", *here),
        ("monitor", run, "--web", *here[:2]),
    ]
    with ExitStack() as stack:
        victims = []
        for number, command in enumerate(commands):
            own = folder / str(number)
            own.mkdir()
            victims.append(stack.enter_context(Victim(own, *command, run=fresh_name())))
            victims[-1].await_begin()
        for victim in dice.sample(victims, len(victims)):
            victim.await_life(dice.uniform(0.0, 1.5))
            number = dice.choice((signal.SIGINT, signal.SIGTERM))
            over = victim.process.poll()  # a run that is over ends its robots and monitors
            if over is None:
                victim.signal(number)
            outcome = victim.left(number, quiet=False)
            _, world, *robots, _ = victims
            lone = victim is world and any(each.process.poll() is not None for each in robots)
            by_itself = over == 3 or (lone and outcome.status == 1)  # a world without robots ends its run
            assert outcome.faults == [] or by_itself, (seed, victim.process.args, outcome)


PROGRAM = """
import disknav, os, signal, threading, time
from protocol.process import signals
signals._HELD_UP = 0.1
class Interrupting:
    calls = 0
    def __init__(self, *_): pass
    def velocity(self, view):
        Interrupting.calls += 1
        if Interrupting.calls == 20: {meanwhile}
        return 0.0, 0.0
def ctrl_c(): os.kill(os.getpid(), signal.SIGINT)
def later(seconds): threading.Timer(seconds, ctrl_c).start()
try: print(disknav.run("swap-2", {{"control.law": "__main__:Interrupting"}}).verdict)
except KeyboardInterrupt: print("interrupted in the law")
try: signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt: print("theirs")
"""


@pytest.mark.parametrize(
    ("meanwhile", "said"),
    [
        ("ctrl_c()", "interrupted\ntheirs\n"),
        ("later(0.1), later(0.5), time.sleep(60.0)", "interrupted in the law\ntheirs\n"),
    ],
    ids=["a law", "a law that is stuck"],
)
def test_in_a_users_program_ctrl_c_ends_the_run_and_then_is_theirs(meanwhile: str, said: str) -> None:
    program = ended(PROGRAM.format(meanwhile=meanwhile), timeout=100.0)
    assert (program.stdout, program.stderr) == (said, "")


def test_a_signal_while_the_command_is_imported_ends_it_without_a_word() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "disknav", "check", "figure-1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not minds(process.pid, signal.SIGTERM):
        assert process.poll() is None
        time.sleep(0.005)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=60.0)
    assert (process.returncode, said) == (143, "")
