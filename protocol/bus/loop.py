"""The main loop of a process: it runs one node on one bus, and gives signs of life to what started it.

A sign of life is a file whose time of change moves, for the probes of container engines, or a notification of
systemd (`sd_notify(3)`: `READY=1` once, `WATCHDOG=1` from then on).
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Final

from protocol.bus.bus import Bus, Node
from protocol.errors import ProcessError
from protocol.process.signals import STOP

_TOGETHER: Final = 256  # events that are handled before the clock is looked at again


def drive(
    node: Node,
    bus: Bus,
    *,
    on_stop: Callable[[], None] | None = None,
    beat: Callable[[float], None] | None = None,
) -> None:
    """Feed `node` with the events of `bus` until it is finished or a signal asks this process to end.

    The bus is closed in any case; before that, `on_stop` may say the last words of a node that a signal
    ended. `beat` is told the time, s, whenever the loop comes round.
    """
    try:
        follow(node, bus, beat)
        if on_stop is not None and not node.finished:
            on_stop()
    finally:
        bus.close()


def follow(node: Node, bus: Bus, beat: Callable[[float], None] | None = None) -> None:
    """Feed `node` with the events of `bus` until it is finished or a signal asks this process to end.

    What has arrived comes before a deadline that is over: the node was late, not its peers.
    """
    receive, handle = bus.receive, node.handle  # looked up once: this goes round for every message
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
            node.wake(now)


PERIOD: Final = 1.0  # s


class Heartbeat:
    """To be called with the time, s, whenever the loop comes round; the first call says that all is ready.

    Args:
        file: is touched; none unless given.
        notify: address of systemd's socket, as `NOTIFY_SOCKET` has it; none if empty.
    """

    def __init__(self, file: Path | None = None, notify: str = "") -> None:
        self._file, self._notify = file, notify
        self._due = -inf

    def __call__(self, now: float) -> None:
        """Raises ProcessError if systemd cannot be told."""
        if now < self._due:
            return
        try:
            if self._file is not None:
                self._file.touch()
            if self._notify:
                self._tell(b"WATCHDOG=1" if self._due > -inf else b"READY=1")
        except OSError as error:
            raise ProcessError(f"no sign of life can be given: {error}") from error
        self._due = now + PERIOD

    def _tell(self, text: bytes) -> None:
        address = f"\0{self._notify[1:]}" if self._notify.startswith("@") else self._notify
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.sendto(text, address)


def heartbeat(file: Path | None) -> Heartbeat | None:
    """As this process was started: into `file`, and to systemd where that asked for it; None for neither."""
    notify = os.environ.get("NOTIFY_SOCKET", "")
    return Heartbeat(file, notify) if file is not None or notify else None
