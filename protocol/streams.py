"""Streams: each declared once, with its type, direction, rate and how the network shall treat it."""

from __future__ import annotations

from typing import NamedTuple

from protocol.messages import Clock, Command, Health, Message, Result, State, Tick, Truth


class Stream(NamedTuple):
    """One kind of published key.

    `reliable`: a publisher waits for room rather than drop (congestion control BLOCK); the others
    are for whoever watches, and a slow watcher loses samples instead of holding up the fleet.
    """

    name: str
    message: type[Message]
    publisher: str  # "world" or "robot"
    rate: str
    reliable: bool
    recorded: bool
    limit: int  # largest payload accepted, bytes


_EACH_TICK = "once a tick and robot; again if lock-step waits for somebody for 0.5 s"
_STREAMS = (
    Stream("tick", Tick, "world", _EACH_TICK, True, True, 128 * 1024),
    Stream("state", State, "robot", _EACH_TICK, True, True, 128 * 1024),
    Stream("command", Command, "robot", _EACH_TICK, True, True, 1024),
    Stream(
        "clock",
        Clock,
        "world",
        "at most every 0.05 s, at ticks with a process fault, every 0.1 s while the world waits",
        False,
        True,
        64 * 1024,
    ),
    Stream("truth", Truth, "world", "once a tick, up to 0.05 s of ticks together", False, True, 64 * 1024),
    Stream("health", Health, "robot", "every 0.5 s, and at the end", False, True, 128 * 1024),
    Stream("result", Result, "world", "once, at the end", True, False, 4 * 1024 * 1024),
)

STREAMS = {stream.name: stream for stream in _STREAMS}
