"""The interface of a bus, and the main loop of a process. Two implementations: `zenoh` and `local`.

A bus turns messages, requests and presence into events, taken one at a time by `receive`; it calls no handler
from a thread of its own. A `Node` handles these events: its own process drives it (`drive`) or, in one
process with others, the in-process network.

A sign of life is a file whose time of change moves, for the probes of container engines, or a notification of
systemd (`sd_notify(3)`: `READY=1` once, `WATCHDOG=1` from then on).
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterable
from math import inf
from pathlib import Path
from typing import Final, NamedTuple, Protocol, final

from mypy_extensions import mypyc_attr

from protocol.errors import ProcessError
from protocol.keys import Stream
from protocol.process.signals import STOP

Publish = Callable[[bytes], None]


@final
@mypyc_attr(acyclic=True)
class Sample:
    """A publication under `key`. Compiled, a named tuple would take 0.4 us longer of each message's 1.1."""

    def __init__(self, key: str, payload: bytes) -> None:
        self.key, self.payload = key, payload


class RawSample(NamedTuple):
    """A publication outside this fleet's streams, or a reply to a `post`, under `key`."""

    key: str
    payload: bytes
    attachment: bytes = b""


class Presence(NamedTuple):
    """A liveliness token appeared or disappeared."""

    key: str
    alive: bool


class Query(NamedTuple):
    """A request under `key`; exactly one `reply` is expected."""

    key: str
    payload: bytes
    reply: Callable[[bytes], None]


Event = Sample | RawSample | Presence | Query


class Bus(Protocol):
    """One participant's connection. Not thread-safe: one thread owns it."""

    def publisher(self, stream: Stream, key: str) -> Publish:
        """Declare a publication; returns a function that publishes a payload, but not to this bus."""

    @property
    def identity(self) -> str:
        """Unique name of this connection, usable as one chunk of a key."""

    def raw_publisher(self, key: str, attach: Callable[[], bytes] | None = None) -> Publish:
        """The same for a key outside this fleet, with attachments made by `attach`; a payload that cannot be
        sent at once is dropped."""

    def listen(self, key_expression: str) -> None:
        """Subscribe to a key expression outside this fleet; its events are `RawSample`, with attachments."""

    def subscribe(self, *key_expressions: str) -> None:
        """Subscribe to key expressions, of which plain keys cost least."""

    def unsubscribe(self, key: str) -> None:
        """Unsubscribe from a plain key."""

    def expect(self, keys: Iterable[str]) -> None:
        """Name keys that a pattern will match; a sample under one of them costs less."""

    def watch(self, key_expression: str) -> None:
        """Request presence of liveliness tokens, including present ones."""

    def serve(self, key: str) -> None:
        """Answer the requests under `key`."""

    def announce(self, key: str) -> None:
        """Declare a liveliness token, which lasts until `close`, or the death of this process."""

    def ask(self, key: str, payload: bytes, timeout: float, *, once: bool = False) -> list[bytes]:
        """Request, and wait for all replies; raises BusError after `timeout` s without one. An order is sent
        `once`, when the key is served; a question, or whatever may be obeyed twice, is repeated."""

    def post(self, key: str, payload: bytes) -> None:
        """Send a request without waiting: replies are events."""

    def tokens(self, key_expression: str) -> list[str]:
        """Keys of all present liveliness tokens, including those of this participant."""

    def receive(self, timeout: float) -> Event | None:
        """The next event, or None after `timeout` seconds (0: without waiting)."""

    def close(self) -> None:
        """Disconnect, and withdraw all declarations; may be called twice."""


class Node(Protocol):
    """A participant, driven by events."""

    def handle(self, event: Event) -> None:
        """React to one event."""

    def on_timer(self, now: float) -> None:
        """Handle the passing of time: `now` (s, monotonic) has reached `deadline`."""

    @property
    def deadline(self) -> float:
        """Time of the next `on_timer`, s, monotonic; infinity for never."""

    @property
    def finished(self) -> bool:
        """Whether the node is done."""


_TOGETHER: Final = 256  # most events handled between two looks at the clock


def drive(
    node: Node,
    bus: Bus,
    *,
    on_stop: Callable[[], None] | None = None,
    beat: Callable[[float], None] | None = None,
) -> None:
    """As `follow`; in any case close the bus, after `on_stop` has sent a stopped node's last messages."""
    try:
        follow(node, bus, beat)
        if on_stop is not None and not node.finished:
            on_stop()
    finally:
        bus.close()


def follow(node: Node, bus: Bus, beat: Callable[[float], None] | None = None) -> None:
    """Feed `node` with the events of `bus` until it is finished or a signal asks this process to end.

    `beat` is called with the time, s, in each round of the loop. Events that have arrived precede a passed
    deadline: the node was late, not its peers.
    """
    receive, handle = bus.receive, node.handle  # looked up once for all messages
    while not (node.finished or STOP.requested):
        event = receive(max(0.0, node.deadline - time.monotonic()))
        handled = 0
        while event is not None:
            handle(event)
            handled += 1
            if handled == _TOGETHER or node.finished:
                break
            event = receive(0.0)
        now = time.monotonic()
        if beat is not None:
            beat(now)
        if now >= node.deadline and not node.finished:
            node.on_timer(now)


PERIOD: Final = 1.0  # s


class Heartbeat:
    """Called with the time, s, in each round of the loop; the first call reports that the process is ready.

    Args:
        file: is touched; none by default.
        notify: address of systemd's socket, as in `NOTIFY_SOCKET`; none if empty.
    """

    def __init__(self, file: Path | None = None, notify: str = "") -> None:
        self._file, self._notify = file, notify
        self._due = -inf

    def __call__(self, now: float) -> None:
        """Raises ProcessError if systemd cannot be notified."""
        if now < self._due:
            return
        try:
            if self._file is not None:
                self._file.touch()
            if self._notify:
                self._send(b"WATCHDOG=1" if self._due > -inf else b"READY=1")
        except OSError as error:
            raise ProcessError(f"no sign of life can be given: {error}") from error
        self._due = now + PERIOD

    def _send(self, text: bytes) -> None:
        address = f"\0{self._notify[1:]}" if self._notify.startswith("@") else self._notify
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.sendto(text, address)


def heartbeat(file: Path | None) -> Heartbeat | None:
    """The heartbeat of this process, into `file`, and to systemd if that started it; None for neither."""
    notify = os.environ.get("NOTIFY_SOCKET", "")
    return Heartbeat(file, notify) if file is not None or notify else None
