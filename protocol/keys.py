"""Key expressions, built and parsed in this one place.

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
other streams are published (declared with types and rates in `protocol.streams`).
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final, NamedTuple

from protocol.errors import KeyGrammarError

ROBOT_STREAMS = ("tick", "state", "command", "health", "goalstatus", "wish", "join")
WORLD_STREAMS = ("clock", "truth", "summary", "result", "scenario", "steering", "operation")
TOKEN: Final = "alive"
SESSION: Final = "[A-Za-z0-9_-]{1,64}"  # grammar of a session

LARGEST_ID = 999_999_999
_RUN = re.compile(r"[A-Za-z0-9_-]+")
_KEY = re.compile(
    r"disknav/(?P<run>[A-Za-z0-9_-]+)/(?:robot/(?P<robot>[1-9][0-9]{0,8})|world)"
    rf"/(?:(?P<stream>[a-z]+)|{TOKEN}/(?P<session>{SESSION}))"
)


class Address(NamedTuple):
    """A parsed key.

    Attributes:
        robot: None for the world's.
        stream: `TOKEN` for a liveliness token.
        session: of the process that a token stands for, else empty.
    """

    run: str
    robot: int | None
    stream: str
    session: str = ""


def checked_run(run: str) -> str:
    """Return `run` if it may stand in a key, else raise KeyGrammarError."""
    if not (isinstance(run, str) and _RUN.fullmatch(run)):
        raise KeyGrammarError(f"run name {run!r}: use letters, digits, '_' and '-' only")
    return run


def robot_key(run: str, robot: int, stream: str) -> str:
    """Key of one robot's stream, e.g. `disknav/demo/robot/3/state`."""
    if not 1 <= robot <= LARGEST_ID:
        raise KeyGrammarError(f"robot {robot}: ids are whole numbers from 1 to {LARGEST_ID}")
    if stream not in ROBOT_STREAMS:
        raise KeyGrammarError(f"no robot stream {stream!r}; there are {', '.join(ROBOT_STREAMS)}")
    return f"disknav/{run}/robot/{robot}/{stream}"


def world_key(run: str, stream: str) -> str:
    """Key of one of the world's streams, e.g. `disknav/demo/world/clock`."""
    if stream not in WORLD_STREAMS:
        raise KeyGrammarError(f"no world stream {stream!r}; there are {', '.join(WORLD_STREAMS)}")
    return f"disknav/{run}/world/{stream}"


def every_robot(run: str, stream: str) -> str:
    """Key expression that matches `stream` of all robots of a run."""
    if stream not in ROBOT_STREAMS:
        raise KeyGrammarError(f"no robot stream {stream!r}; there are {', '.join(ROBOT_STREAMS)}")
    return f"disknav/{run}/robot/*/{stream}"


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
    """Whether a key is such a token."""
    return key.startswith("disknav-base/")


def session_of(epoch: int) -> str:
    """The session that the token of a world names."""
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


@lru_cache(maxsize=1 << 14)  # every message is heard under a key, and there are few
def parse(key: str) -> Address:
    """Take a key apart; raises KeyGrammarError on anything that the grammar does not allow."""
    found = _KEY.fullmatch(key)
    if found is not None:
        run, robot, stream, session = found.group("run", "robot", "stream", "session")
        speaker = None if robot is None else int(robot)
        if session is not None:
            return Address(run, speaker, TOKEN, session)
        if stream in (WORLD_STREAMS if speaker is None else ROBOT_STREAMS):
            return Address(run, speaker, stream)
    raise KeyGrammarError(f"{key!r} is not a key of this protocol")
