"""Streams and questions: each declared once, with its type, direction, rate and treatment by the network.

A router's access rules follow from this page (`deploy.security.roster`).
"""

from __future__ import annotations

from typing import NamedTuple

from protocol.messages import (
    Clock,
    Command,
    GoalStatus,
    Health,
    Message,
    Result,
    State,
    Summary,
    Tick,
    Truth,
    Wish,
)


class Stream(NamedTuple):
    """One kind of published key.

    `reliable`: a publisher waits for room rather than drop (congestion control BLOCK); the others
    are for monitors, and a slow monitor loses samples instead of holding up the fleet.
    `heard_by`: which processes may subscribe besides monitors, which hear everything; the publisher of a sign
    of life hears it, too, for the probe beside it has no other certificate.
    """

    name: str
    message: type[Message]
    publisher: str  # "world", "robot" or "operator"
    heard_by: tuple[str, ...]  # of "itself", the robot in the key; "robots", all of them; "world"
    rate: str
    reliable: bool
    recorded: bool
    limit: int  # largest payload accepted, bytes


class Question(NamedTuple):
    """One kind of key under which the world answers requests (`protocol.joining`, `protocol.operations`)."""

    name: str
    asked_by: str  # "itself", the robot in the key; "monitor", or "operator"


_EACH_TICK = "once a tick and robot; again if lock-step waits for a robot for 0.5 s"
_STREAMS = (
    Stream("tick", Tick, "world", ("itself",), _EACH_TICK, True, True, 8 * 1024**2),
    Stream("state", State, "robot", ("robots",), _EACH_TICK, True, True, 128 * 1024),
    Stream("command", Command, "robot", ("world",), _EACH_TICK, True, True, 8 * 1024),
    Stream(
        "summary",
        Summary,
        "world",
        ("robots",),
        "every 0.5 s of simulated time, or 3 ticks if longer, where some robots are far from each other",
        True,
        False,
        64 * 1024,
    ),
    Stream(
        "clock",
        Clock,
        "world",
        ("world",),
        "once a tick, in lock-step at full speed every 0.05 s and at ticks with a process fault; "
        "every 0.1 s while the world waits",
        False,
        True,
        256 * 1024,
    ),
    Stream(
        "truth", Truth, "world", (), "once a tick, as many together as a Clock is for", False, True, 64 * 1024
    ),
    Stream("health", Health, "robot", ("itself",), "every 0.5 s, and at the end", False, True, 128 * 1024),
    Stream(
        "goalstatus",
        GoalStatus,
        "world",
        (),
        "when an order is accepted, at every point, and at its end",
        False,
        True,
        1024,
    ),
    Stream(
        "wish",
        Wish,
        "operator",
        ("itself",),
        "as often as a planner likes, for a robot whose law is external",
        False,
        False,
        256,
    ),
    Stream("result", Result, "world", (), "once, at the end", True, False, 4 * 1024 * 1024),
)

STREAMS = {stream.name: stream for stream in _STREAMS}
QUESTIONS = (
    Question("join", "itself"),
    Question("scenario", "monitor"),
    Question("steering", "monitor"),
    Question("operation", "operator"),
)
