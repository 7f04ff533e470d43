"""Signals as an event: noted at any moment, waking what waits, and never an exception out of nowhere."""

import os
import signal
import subprocess
import sys
import threading
import time
from queue import SimpleQueue

import pytest

from protocol.process.signals import ENDING, STOP, Stopped
from tests.scripts import ended

PATIENCE = 20.0  # s


TIMERS: list[threading.Timer] = []


@pytest.fixture(autouse=True)
def listening() -> object:
    """Ctrl-C is an event for the time of a test."""
    with STOP.listening():
        yield
        while TIMERS:
            TIMERS.pop().join()


def later() -> None:
    """A signal comes to this process in a moment."""
    TIMERS.append(threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)))
    TIMERS[-1].start()


def test_a_signal_is_noted_and_raises_nothing() -> None:
    assert not STOP.requested
    STOP.check()
    signal.raise_signal(signal.SIGINT)
    signal.raise_signal(signal.SIGINT)
    assert STOP.requested
    assert (STOP.number, STOP.count, STOP.status) == (signal.SIGINT, 2, 130)
    with pytest.raises(Stopped):
        STOP.check()


def test_a_wait_ends_with_a_signal() -> None:
    assert not STOP.wait(0.001)
    later()
    began = time.monotonic()
    assert STOP.wait(PATIENCE)
    assert STOP.wait()  # and any further one at once
    assert time.monotonic() < began + PATIENCE / 2


def test_what_waits_for_a_queue_is_woken_also_by_a_signal_that_came_before() -> None:
    queue: SimpleQueue[str] = SimpleQueue()
    later()
    with STOP.calling(lambda: queue.put("woken")):
        assert queue.get(timeout=PATIENCE) == "woken"
    signal.raise_signal(signal.SIGINT)
    assert queue.empty()  # it is called no more
    with STOP.calling(lambda: queue.put("at once")):
        assert queue.get(timeout=0.0) == "at once"


def test_afterwards_ctrl_c_is_the_users_again() -> None:
    with STOP.listening():  # nested, it changes nothing
        signal.raise_signal(signal.SIGINT)
    assert STOP.requested
    process = ended(
        "import signal\nfrom protocol.process.signals import STOP\n"
        "with STOP.listening(): signal.raise_signal(signal.SIGINT); assert STOP.requested\n"
        "assert not STOP.requested and not STOP.count\n"
        "try: signal.raise_signal(signal.SIGINT)\nexcept KeyboardInterrupt: print('raised')\n"
    )
    assert (process.stdout, process.stderr) == ("raised\n", "")


def test_a_handler_of_the_users_is_left_alone() -> None:
    process = ended(
        "import signal\nfrom protocol.process.signals import STOP\n"
        "signal.signal(signal.SIGINT, lambda *_: print('mine'))\n"
        "with STOP.listening(): signal.raise_signal(signal.SIGINT)\n"
        "assert not STOP.requested\n"
    )
    assert (process.stdout, process.stderr) == ("mine\n", "")


@pytest.mark.parametrize("number", ENDING)
def test_a_process_that_looks_at_nothing_can_still_be_ended(number: int) -> None:
    """Code of others may be stuck; two seconds are enough to see that."""
    process = ended(
        "import math, signal\nfrom protocol.process import signals\nsignals._HELD_UP = math.inf\n"
        f"signal.signal({int(number)}, signal.SIG_DFL)\nsignals.STOP.listen()\n"  # nohup has hangups ignored
        f"signal.raise_signal({int(number)})\nsignal.raise_signal({int(number)})\n"
        "print('held up', flush=True)\nsignals._HELD_UP = 0.0\n"
        f"signal.raise_signal({int(number)})\nprint('never')\n"
    )
    assert (process.returncode, process.stdout, process.stderr) == (-number, "held up\n", "")


def test_hangup_stays_ignored_as_nohup_asks_and_ctrl_c_does_not() -> None:
    process = ended(
        "import signal\nfrom protocol.process.signals import STOP\n"
        "for each in (signal.SIGHUP, signal.SIGINT): signal.signal(each, signal.SIG_IGN)\n"
        "STOP.listen()\nsignal.raise_signal(signal.SIGHUP)\nassert not STOP.requested\n"
        "signal.raise_signal(signal.SIGINT)\nassert STOP.requested\n"
        "STOP.ignore()\nsignal.raise_signal(signal.SIGTERM)\nassert STOP.count == 1\n"
    )
    assert (process.returncode, process.stderr) == (0, "")


def test_processes_that_start_where_signals_are_held_leave_them_to_this_one_until_they_listen() -> None:
    listens = (
        "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\nprint('still there')\n"
        "from protocol.process.signals import STOP\nSTOP.listen()\nprint(STOP.status)\n"
    )
    with STOP.held():
        process = subprocess.run(
            [sys.executable, "-c", listens], stdout=subprocess.PIPE, text=True, timeout=PATIENCE, check=True
        )
        signal.raise_signal(signal.SIGINT)
        assert not STOP.requested
    assert STOP.requested
    assert process.stdout == "still there\n130\n"
