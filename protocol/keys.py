"""Keys: their grammar, built and parsed in this one place; and the streams and questions under them, each
declared once, with its type, direction, rate and treatment by the network.

Grammar::

    key    = "disknav/" run "/robot/" id "/" (robot-stream | token)
           | "disknav/" run "/world/" (world-stream | token)
    run    = one or more of A-Z a-z 0-9 _ -           fleets with different runs share a network
    id     = decimal integer from 1 to 999999999, no leading zero
    robot-stream = "tick" | "state" | "command" | "health" | "goalstatus" | "wish" | "join"
    world-stream = "clock" | "truth" | "summary" | "result" | "scenario" | "steering" | "operation"
    token   = "alive/" session
    session = 1 to 64 of A-Z a-z 0-9 _ -              one process; of a world, its epoch in hexadecimal digits

    driver  = "disknav-base/" topic "/" session       of the process that drives a base, whatever its run
    topic   = ROS domain and topic of the base's velocities, with "%" for "/"

Tokens and drivers are liveliness tokens. `join`, `scenario`, `steering` and `operation` are queryables; all
other streams are published. A router's access rules are derived from this module (`deploy.security.roster`).
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final, NamedTuple

from protocol.errors import KeyGrammarError
from protocol.messages import (
    HIGHEST_ID,
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
    """One kind of published key."""

    name: str
    message: type[Message]
    publisher: str  # "world", "robot" or "operator"
    # Processes that may subscribe besides monitors, which receive everything: of "itself", the robot in the
    # key; "robots", all of them; "world". A robot receives its own health, too, and the world its clock: a
    # probe on its host uses the same certificate.
    heard_by: tuple[str, ...]
    rate: str
    # A publisher waits for room rather than drop (congestion control BLOCK); the others are for monitors, and
    # a slow monitor loses samples instead of blocking the fleet.
    reliable: bool
    recorded: bool
    limit: int  # largest payload accepted, bytes


class Question(NamedTuple):
    """One kind of key under which the world answers requests (`protocol.joining`, `protocol.operations`)."""

    name: str
    asked_by: str  # "itself", the robot in the key; "monitor", or "operator"


_EACH_TICK = "once a tick and robot; again if lock-step waits for a robot for 0.5 s"
_SUMMARY = "every 0.5 s of simulated time, or 3 ticks if longer, where some robots are far from each other"
_CLOCK = (
    "once a tick, in lock-step at full speed every 0.05 s and at ticks with a process fault; "
    "every 0.1 s while the world waits"
)
_TRUTH = "once a tick, as many together as a Clock is for"
_GOAL = "when an order is accepted, at every point, and at its end"
_WISH = "as often as a planner likes, for a robot whose law is external"
_STREAMS = (
    Stream("tick", Tick, "world", ("itself",), _EACH_TICK, True, True, 8 * 1024**2),
    Stream("state", State, "robot", ("robots",), _EACH_TICK, True, True, 128 * 1024),
    Stream("command", Command, "robot", ("world",), _EACH_TICK, True, True, 8 * 1024),
    Stream("summary", Summary, "world", ("robots",), _SUMMARY, True, False, 64 * 1024),
    Stream("clock", Clock, "world", ("world",), _CLOCK, False, True, 256 * 1024),
    Stream("truth", Truth, "world", (), _TRUTH, False, True, 64 * 1024),
    Stream("health", Health, "robot", ("itself",), "every 0.5 s, and at the end", False, True, 128 * 1024),
    Stream("goalstatus", GoalStatus, "world", (), _GOAL, False, True, 1024),
    Stream("wish", Wish, "operator", ("itself",), _WISH, False, False, 256),
    Stream("result", Result, "world", (), "once, at the end", True, False, 4 * 1024 * 1024),
)

STREAMS = {stream.name: stream for stream in _STREAMS}
QUESTIONS = (
    Question("join", "itself"),
    Question("scenario", "monitor"),
    Question("steering", "monitor"),
    Question("operation", "operator"),
)
_SPOKEN = tuple(each.name for each in _STREAMS if "robot" in each.message.__struct_fields__)
ROBOT_STREAMS = (*_SPOKEN, "join")
WORLD_STREAMS = tuple(each.name for each in (*_STREAMS, *QUESTIONS) if each.name not in ROBOT_STREAMS)
TOKEN: Final = "alive"
SESSION: Final = "[A-Za-z0-9_-]{1,64}"  # grammar of a session

_RUN = re.compile(r"[A-Za-z0-9_-]+")
_KEY = re.compile(
    r"disknav/(?P<run>[A-Za-z0-9_-]+)/(?:robot/(?P<robot>[1-9][0-9]{0,8})|world)"
    rf"/(?:(?P<stream>[a-z]+)|{TOKEN}/(?P<session>{SESSION}))"
)


class Address(NamedTuple):
    """A parsed key."""

    run: str
    robot: int | None  # None for the world's
    stream: str  # `TOKEN` for a liveliness token
    session: str = ""  # of the process of a token, otherwise empty


def checked_run(run: str) -> str:
    """Return `run` if it is valid in a key, otherwise raise KeyGrammarError."""
    if not (isinstance(run, str) and _RUN.fullmatch(run)):
        raise KeyGrammarError(f"run name {run!r}: use letters, digits, '_' and '-' only")
    return run


@lru_cache(maxsize=1 << 14)  # a robot looks up the keys of its neighbours in most ticks
def robot_key(run: str, robot: int, stream: str) -> str:
    """Key of one robot's stream, e.g. `disknav/demo/robot/3/state`."""
    if not 1 <= robot <= HIGHEST_ID:
        raise KeyGrammarError(f"robot {robot}: ids are whole numbers from 1 to {HIGHEST_ID}")
    return f"disknav/{run}/robot/{robot}/{_checked(stream, 'robot', ROBOT_STREAMS)}"


def world_key(run: str, stream: str) -> str:
    """Key of one of the world's streams, e.g. `disknav/demo/world/clock`."""
    return f"disknav/{run}/world/{_checked(stream, 'world', WORLD_STREAMS)}"


def every_robot(run: str, stream: str) -> str:
    """Key expression that matches `stream` of all robots of a run."""
    return f"disknav/{run}/robot/*/{_checked(stream, 'robot', ROBOT_STREAMS)}"


def _checked(stream: str, whose: str, known: tuple[str, ...]) -> str:
    if stream not in known:
        raise KeyGrammarError(f"no {whose} stream {stream!r}; there are {', '.join(known)}")
    return stream


def robot_token(run: str, robot: int, session: str) -> str:
    """Key of the liveliness token of one process of a robot, e.g. `disknav/demo/robot/3/alive/5c1f`."""
    return f"disknav/{run}/robot/{robot}/{TOKEN}/{session}"


def world_token(run: str, session: str) -> str:
    """Key of the liveliness token of a world."""
    return f"disknav/{run}/world/{TOKEN}/{session}"


def driver_token(topic: str, session: str) -> str:
    """Key of the liveliness token of a process that drives the base with a domain and topic."""
    return f"disknav-base/%{topic.replace('/', '%')}/{session}"


def is_driver(key: str) -> bool:
    """Whether a key is the token of a driver."""
    return key.startswith("disknav-base/")


def session_of(epoch: int) -> str:
    """The session in the token of a world."""
    return f"{epoch:08x}"


def robot_tokens(run: str, robot: int | None = None) -> str:
    """Key expression that matches the tokens of all processes of a robot, or of all robots."""
    return robot_token(run, robot, "*") if robot is not None else f"disknav/{run}/robot/*/{TOKEN}/*"


def world_tokens(run: str) -> str:
    """Key expression that matches the tokens of all worlds of a run."""
    return world_token(run, "*")


def everything(run: str) -> str:
    """Key expression that matches every key of a run."""
    return f"disknav/{run}/**"


@lru_cache(maxsize=1 << 14)  # every message has a key, and there are few
def parse(key: str) -> Address:
    """Parse a key; raises KeyGrammarError on anything that the grammar does not allow."""
    found = _KEY.fullmatch(key)
    if found is not None:
        run, robot, stream, session = found.group("run", "robot", "stream", "session")
        speaker = None if robot is None else int(robot)
        if session is not None:
            return Address(run, speaker, TOKEN, session)
        if stream in (WORLD_STREAMS if speaker is None else ROBOT_STREAMS):
            return Address(run, speaker, stream)
    raise KeyGrammarError(f"{key!r} is not a key of this protocol")
