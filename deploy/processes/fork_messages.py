"""What a supervisor and its fork server say to each other: requests one way, news the other.

Requests are pickled. News are not, because they may come from another host: whoever has taken that
over must not be able to run anything here.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

import msgspec
from msgspec import Meta

from deploy.processes.scheduling import ORDINARY, Scheduling


class Start(NamedTuple):
    """Request: fork a process that calls `entry` ("module:function") with `arguments`.

    `reports`: the function gets one more argument, a callable that sends text to the supervisor.
    """

    life: int  # names this one process, for ever
    name: str
    entry: str
    arguments: tuple[Any, ...]
    reports: bool
    scheduling: Scheduling = ORDINARY


class Signal(NamedTuple):
    """Request: send a signal. To a process that has ended, nothing is sent."""

    life: int
    number: int


class Store(NamedTuple):
    """Request, to a fork server on another host: put a file, its owner's alone, into its folder."""

    name: str
    content: bytes


class Beat(NamedTuple):
    """Request: nothing; the supervisor is there."""


class _News(msgspec.Struct, frozen=True, tag=True, array_like=True, forbid_unknown_fields=True):
    """Base of what the fork server tells; `life` says of which process."""

    life: int


class Started(_News, frozen=True):
    """News: the process exists."""

    pid: Annotated[int, Meta(ge=1, lt=1 << 31)]


class Report(_News, frozen=True):
    """News: the process says something."""

    text: str


class Exited(_News, frozen=True):
    """News: the process is gone; the exit code is negative for a signal."""

    code: Annotated[int, Meta(ge=-64, le=255)]
    cpu_s: Annotated[float, Meta(ge=0, le=1e9)]
    max_rss_mb: Annotated[float, Meta(ge=0, le=1e9)]
    why: str = ""  # where the exit code does not say it


Request = Start | Signal | Store | Beat
News = Started | Report | Exited

MAX_NEWS = 1 << 23  # bytes; twice the largest result

_encoder = msgspec.msgpack.Encoder()
_decoder = msgspec.msgpack.Decoder(News)


def encode_news(news: News) -> bytes:
    """News as they cross the channel."""
    return _encoder.encode(news)


def decode_news(payload: bytes) -> News:
    """The reverse; raises one of `protocol.codec.DAMAGED`."""
    decoded: News = _decoder.decode(payload)
    return decoded
