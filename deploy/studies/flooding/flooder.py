"""The process that floods: garbage at a given rate whenever it is told to, through a session of its own."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from itertools import cycle, islice
from multiprocessing.connection import Connection as Channel
from typing import Any, NamedTuple

from deploy.studies.endurance.side_process import SideProcess
from deploy.studies.flooding.garbage import garbage
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.process.signals import ENDING
from protocol.process.title import entitle
from protocol.streams import STREAMS

_PULSE = 0.001  # s between bursts
_NICENESS = 19  # it stands for another host, whose processors are not the fleet's


class Flooded(NamedTuple):
    """One flood: messages handed to the network, and how long it took, s."""

    sent: int
    seconds: float


class Flooder(SideProcess):
    """The launcher's side.

    Raises:
        ProcessError: the process has ended.
    """

    def __init__(self, connection: Connection, run: str, robots: tuple[int, ...], rate: float) -> None:
        """Connect, without waiting for it; `rate` in messages per second."""
        super().__init__("flooder", main, connection, run, robots, rate)

    def connected(self) -> None:
        """Wait until it is; comes first."""
        self._hear()

    def begin(self) -> None:
        """Let it flood from now on."""
        self._say(True)

    def end(self) -> Flooded:
        """Stop the flood."""
        self._say(False)
        flooded: Flooded = self._hear()
        return flooded


def main(
    channel: Channel[Any, Any], connection: Connection, run: str, robots: tuple[int, ...], rate: float
) -> None:
    """Flood between two words of the other end, until that is gone."""
    entitle("flooder", run)
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)  # the parent alone decides what a Ctrl-C means
    os.nice(_NICENESS)
    bus = ZenohBus(connection)
    try:
        messages = cycle(_declared(bus, run, robots))
        channel.send(None)
        while True:
            channel.recv()
            channel.send(_flood(messages, rate, channel))
    except (EOFError, ConnectionError):
        return
    finally:
        bus.close()


def _declared(
    bus: ZenohBus, run: str, robots: tuple[int, ...]
) -> list[tuple[Callable[[bytes], None], bytes]]:
    """One cycle of garbage with a publisher for each key; a publisher waits for room, so all is sent."""
    cycled = garbage(run, robots)
    publishers = {
        key: bus.publisher(STREAMS["state"], key) for key in dict.fromkeys(key for key, _ in cycled)
    }
    return [(publishers[key], payload) for key, payload in cycled]


def _flood(
    messages: Iterator[tuple[Callable[[bytes], None], bytes]], rate: float, channel: Channel[Any, Any]
) -> Flooded:
    began = until = time.monotonic()
    sent = 0
    while not channel.poll(_PULSE):
        due = int((time.monotonic() - began) * rate)
        for publish, payload in islice(messages, due - sent):
            publish(payload)
        sent, until = due, time.monotonic()
    channel.recv()
    return Flooded(sent, until - began)
