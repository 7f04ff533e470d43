"""The main loop of a process: what has arrived comes before a deadline, and a flood does not hold one off."""

import signal
from math import inf

from protocol.bus.bus import Event, Sample
from protocol.bus.local import LocalBus, LocalNetwork
from protocol.bus.loop import follow
from protocol.process.signals import STOP

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
