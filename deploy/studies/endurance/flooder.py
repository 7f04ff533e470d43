"""The process that floods: garbage at a given rate whenever it is told to, through a session of its own."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator
from itertools import cycle, islice
from multiprocessing.connection import Connection as Channel
from types import TracebackType
from typing import Any, NamedTuple, Self

from deploy.studies.endurance.garbage import garbage
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import ProcessError
from protocol.process.title import entitle
from protocol.streams import STREAMS

_PULSE = 0.001  # s between bursts
_PATIENCE = 30.0  # s for the flooder to say something
_NICENESS = 19  # it stands for another host, whose processors are not the fleet's


class Flooded(NamedTuple):
    """One flood: messages handed to the network, and how long it took, s."""

    sent: int
    seconds: float


class Flooder:
    """The launcher's side; a context manager, which ends the process.

    Raises:
        ProcessError: the process has ended.
    """

    def __init__(self, connection: Connection, run: str, robots: tuple[int, ...], rate: float) -> None:
        """Connect, without waiting for it; `rate` in messages per second."""
        context = multiprocessing.get_context("spawn")
        self._channel, theirs = context.Pipe()
        self._process = context.Process(
            target=main, args=(theirs, connection, run, robots, rate), name="flooder", daemon=True
        )
        self._process.start()
        theirs.close()

    def __enter__(self) -> Self:
        self._hear()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._channel.close()
        self._process.join(_PATIENCE)
        self._process.kill()
        self._process.join()

    @property
    def pid(self) -> int:
        """Of the process that floods."""
        return self._process.pid or 0

    def begin(self) -> None:
        """Let it flood from now on."""
        self._channel.send(True)

    def end(self) -> Flooded:
        """Stop the flood."""
        self._channel.send(False)
        flooded: Flooded = self._hear()
        return flooded

    def _hear(self) -> Any:
        try:
            if self._channel.poll(_PATIENCE):
                return self._channel.recv()
        except (EOFError, ConnectionError):
            self._process.join(_PATIENCE)
        raise ProcessError(f"the flooder says nothing (exit status {self._process.exitcode}); see above")


def main(
    channel: Channel[Any, Any], connection: Connection, run: str, robots: tuple[int, ...], rate: float
) -> None:
    """Flood between two words of the other end, until that is gone."""
    entitle("flooder", run)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent alone decides what a Ctrl-C means
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
