"""Key expressions, built and parsed in this one place.

Grammar::

    key    = "disknav/" run "/robot/" id "/" robot-stream
           | "disknav/" run "/world/" world-stream
    run    = one or more of A-Z a-z 0-9 _ -           fleets with different runs share a network
    id     = decimal integer from 1 to 999999999, no leading zero
    robot-stream = "tick" | "state" | "command" | "health" | "goalstatus" | "goal" | "join" | "alive"
    world-stream = "clock" | "truth" | "summary" | "result" | "scenario" | "steering" | "halt"
                   | "fleet" | "things" | "alive"

`alive` keys are liveliness tokens, `goal`, `join`, `scenario`, `steering`, `halt`, `fleet` and `things` are
queryables,
all others are published streams (declared with types and rates in `protocol.streams`).
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

from protocol.errors import KeyGrammarError

ROBOT_STREAMS = ("tick", "state", "command", "health", "goalstatus", "goal", "join", "alive")
WORLD_STREAMS = (
    *("clock", "truth", "summary", "result"),
    *("scenario", "steering", "halt", "fleet", "things", "alive"),
)

LARGEST_ID = 999_999_999
_RUN = re.compile(r"[A-Za-z0-9_-]+")
_KEY = re.compile(
    r"disknav/(?P<run>[A-Za-z0-9_-]+)/(?:robot/(?P<robot>[1-9][0-9]{0,8})/(?P<rs>[a-z]+)|world/(?P<ws>[a-z]+))"
)


class Address(NamedTuple):
    """A parsed key. `robot` is None for the world's streams."""

    run: str
    robot: int | None
    stream: str


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


def everything(run: str) -> str:
    """Key expression that matches every key of a run."""
    return f"disknav/{run}/**"


@lru_cache(maxsize=1 << 14)  # every message is heard under a key, and there are few
def parse(key: str) -> Address:
    """Take a key apart; raises KeyGrammarError on anything that the grammar does not allow."""
    found = _KEY.fullmatch(key)
    if found is not None:
        run, robot, rs, ws = found.group("run", "robot", "rs", "ws")
        if rs in ROBOT_STREAMS:
            return Address(run, int(robot), rs)
        if ws in WORLD_STREAMS:
            return Address(run, None, ws)
    raise KeyGrammarError(f"{key!r} is not a key of this protocol")
