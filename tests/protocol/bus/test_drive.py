"""The main loop of a process: what has arrived comes before a deadline, and a flood does not hold one off."""

import os
import signal
import threading
import time
from math import inf

import pytest

from protocol.bus.bus import Event, Sample
from protocol.bus.drive import Stop, follow, stop_on_signal, uninterrupted
from protocol.bus.local import LocalBus, LocalNetwork

PATIENCE = 20.0  # s
KEY = "disknav/r/robot/1/state"


class Diary:
    """A node whose deadline is over, which ends with its first wake or with `most` events."""

    def __init__(self, most: float = inf) -> None:
        self.deadline, self.finished = 0.0, False
        self.heard: list[Event] = []
        self.woken = 0
        self._most = most

    def handle(self, event: Event) -> None:
        self.heard.append(event)
        self.finished = len(self.heard) >= self._most

    def wake(self, now: float) -> None:
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


def test_who_has_finished_is_left_alone() -> None:
    diary = Diary(most=2)
    follow(diary, full_bus(3))
    assert len(diary.heard) == 2
    assert diary.woken == 0


def test_only_the_first_signal_stops() -> None:
    cleaned = []

    @stop_on_signal()
    @stop_on_signal()
    def work() -> None:
        try:
            os.kill(os.getpid(), signal.SIGTERM)
        finally:
            os.kill(os.getpid(), signal.SIGTERM)
            cleaned.append("up")

    with pytest.raises(Stop):
        work()
    assert cleaned == ["up"]
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_waits_for_what_must_not_be_left_half_done(number: int) -> None:
    """Also where there are other threads, to one of which the system may give it."""
    done, idle = [], threading.Event()
    other = threading.Thread(target=idle.wait, args=(PATIENCE,))

    def work() -> None:
        with uninterrupted():
            with uninterrupted():
                os.kill(os.getpid(), number)
                time.sleep(0.05)
                done.append("inner")
            done.append("outer")
        done.append("after")

    other.start()
    try:
        with pytest.raises(Stop), stop_on_signal():
            work()
    finally:
        idle.set()
        other.join()
    assert done == ["inner", "outer"]


def test_a_signal_is_handled_as_before_once_nothing_waits() -> None:
    before = signal.getsignal(signal.SIGINT)

    def fail() -> None:
        with uninterrupted():
            assert signal.getsignal(signal.SIGINT) is not before
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert signal.getsignal(signal.SIGINT) is before


def test_elsewhere_than_in_the_main_thread_nothing_has_to_wait() -> None:
    handlers = []

    def work() -> None:
        with uninterrupted():
            handlers.append(signal.getsignal(signal.SIGINT))

    other = threading.Thread(target=work)
    other.start()
    other.join(PATIENCE)
    assert handlers == [signal.getsignal(signal.SIGINT)]


def test_each_signal_that_had_to_wait_is_heard() -> None:
    """Also a closed terminal; and one that ends the process although another is ignored."""
    heard: list[int] = []
    signals = (signal.SIGINT, signal.SIGHUP, signal.SIGTERM)
    before = {number: signal.signal(number, lambda number, _: heard.append(number)) for number in signals}
    try:
        with uninterrupted():
            for number in signals:
                signal.raise_signal(number)
            assert heard == []
        assert heard == list(signals)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
