"""Runs one node on one bus until the node is finished: the whole of a real process's main loop."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from protocol.bus.bus import Bus, Node
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
