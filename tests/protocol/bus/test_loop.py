"""The main loop of a process, in memory and on zenoh: events before deadlines, signals between events."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf

import pytest

from protocol.bus.bus import Event, Sample, drive, follow
from protocol.bus.connection import Connection
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.bus.zenoh import ZenohBus
from protocol.process.signals import STOP, Stopped
from tests.scripts import ended

KEY = "disknav/r/robot/1/state"


class Diary:
    """A node whose deadline is over, which ends with its first wake."""

    def __init__(self) -> None:
        self.deadline, self.finished = 0.0, False
        self.heard: list[Event] = []
        self.woken = 0

    def handle(self, event: Event) -> None:
        self.heard.append(event)

    def on_timer(self, now: float) -> None:
        assert now >= self.deadline
        self.woken += 1
        self.finished = True


def full_bus(samples: int) -> LocalBus:
    bus = LocalNetwork().connect()
    for number in range(samples):
        bus.put(Sample(KEY, bytes([number % 256])))
    return bus


def test_what_has_arrived_comes_before_a_deadline_that_is_over() -> None:
    diary = Diary()
    follow(diary, full_bus(3))
    assert [event.payload for event in diary.heard if isinstance(event, Sample)] == [b"\0", b"\1", b"\2"]
    assert diary.woken == 1


def test_a_flood_does_not_hold_off_a_deadline() -> None:
    diary = Diary()
    follow(diary, full_bus(100_000))
    assert diary.woken == 1
    assert 0 < len(diary.heard) < 1000


def test_a_signal_ends_the_loop_between_two_events() -> None:
    class Interrupted(Diary):
        def handle(self, event: Event) -> None:
            super().handle(event)
            signal.raise_signal(signal.SIGINT)

    diary = Interrupted()
    diary.deadline = inf
    with STOP.listening():
        follow(diary, full_bus(3))
    assert len(diary.heard) == 3
    assert (diary.finished, diary.woken) == (False, 0)


pytestmark = pytest.mark.timeout(30)

ALIVE = "disknav/t/robot/1/alive"
Connect = Callable[..., ZenohBus]


@contextmanager
def signalled() -> Iterator[None]:
    """Inside, a signal comes to this process in a moment; it has come when this ends, which is soon."""
    with STOP.listening():
        timer, began = threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)), time.monotonic()
        timer.start()
        try:
            yield
        finally:
            timer.join()
    assert time.monotonic() < began + 10.0


def test_a_signal_interrupts_receiving(connect: Connect) -> None:
    bus = connect()
    with signalled():
        assert bus.receive(inf) is None
        assert STOP.requested


def test_a_signal_interrupts_a_question(connect: Connect) -> None:
    bus, silent = connect(), connect()
    silent.serve(ALIVE)
    with signalled(), pytest.raises(Stopped):
        bus.ask(ALIVE, b"", 20.0)


def test_a_signal_interrupts_opening() -> None:
    """zenoh itself would go on trying."""
    nowhere = Connection(connect=("tcp/127.0.0.1:1",), timeout=20.0)
    with signalled(), pytest.raises(Stopped):
        ZenohBus(nowhere)


THREADS = """
import os, signal, sys
from contextlib import suppress
from pathlib import Path
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
bus = ZenohBus(Connection(connect=(sys.argv[1],)))
for path in Path("/proc/self/task").iterdir():
    with suppress(FileNotFoundError, ProcessLookupError):  # a thread that has ended meanwhile
        if path.name != str(os.getpid()) and (path / "comm").read_text().startswith(("net-", "rx-")):
            blocked = int((path / "status").read_text().partition("SigBlk:\\t")[2][:16], 16)
            print(blocked >> (signal.SIGTERM - 1) & 1)
bus.close()
"""


def test_zenohs_threads_leave_signals_alone(endpoint: str) -> None:
    """In a process of its own: zenoh begins its threads once a process."""
    process = ended(THREADS, endpoint)
    assert process.stderr == ""
    assert set(process.stdout.split()) == {"1"}


def test_a_signal_ends_driving_after_last_words(connect: Connect) -> None:
    class Interrupted(Diary):
        def on_timer(self, now: float) -> None:
            self.deadline = inf
            timers.append(threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)))
            timers[0].start()

    timers: list[threading.Timer] = []
    bus, words = connect(), []
    with STOP.listening():
        drive(Interrupted(), bus, on_stop=lambda: words.append(bus._session.is_closed()))
        timers[0].join()
    assert words == [False]
    assert bus._session.is_closed()
