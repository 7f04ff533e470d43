"""Starts processes, fast and without orphans: the supervisor's side of the fork server, what they say, and
how the system schedules them.

Measured: 16 processes are up in 0.8 of the time of `multiprocessing`'s own fork server, with 2 MB of
private memory each beside 4, and in a twelfth of the time of an interpreter for each (22 MB), which is what
circus, supervisord and subprocess start. Nor do these say what an ended process cost, or work the same over
ssh. The fork server leads a session of its own, so a terminal's Ctrl-C reaches the supervisor alone.

Requests go one way and are pickled; news come back and are not, because they may come from another host:
one that was taken over must not be able to run anything here.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec
from msgspec import Meta

from protocol.errors import ProcessError
from protocol.process.log import LOG

_LEAST = 2  # robots for each core


def stay_on(core: int) -> None:
    """Keep this process, which has one thread yet, on one processor core; Linux only."""
    try:
        os.sched_setaffinity(0, {core})
    except OSError as error:  # a sandbox may refuse it, a container lose the core: then it is slower
        LOG.info(f"does not stay on core {core}: {error}")


def core_of(turn: int, robots: int) -> int | None:
    """The processor core that a robot's process is to stay on, None where the system had better choose.

    The threads of a robot take turns, and so do robots that wait for each other: left to itself the system
    moves them to whichever core is idle, away from what the other core's cache holds of them. On two cores
    beside other work a tick of 16 and 32 robots takes 0.85 of the time so; with 64 on a quiet machine there
    was no difference (`python -m tests.benchmarks`).

    Args:
        turn: how many robots of the fleet come before this one.
        robots: how many there are.
    """
    if sys.platform != "linux":
        return None
    cores = sorted(os.sched_getaffinity(0))
    return cores[turn % len(cores)] if robots >= _LEAST * len(cores) else None


@dataclass(frozen=True, slots=True)
class Process:
    """One row: what to start, and what its end means."""

    name: str  # unique in a fleet, such as `robot-3`
    entry: str  # "module:function"; it returns the exit status
    arguments: tuple[Any, ...] = ()  # picklable
    vital: bool = False  # the fleet cannot go on without it
    restarts: int = 0  # how many times it is started again by itself after it failed
    reports: bool = False  # the function takes one more argument: a callable for text to the supervisor
    core: int | None = None  # number of the processor core that it stays on; as the system likes unless given
    patience: float = 5.0  # s that it may take to end after SIGTERM; it is killed then


class Start(NamedTuple):
    """Request: fork a process."""

    life: int  # names this one process, for ever
    process: Process


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


class ProcessReport(_News, frozen=True):
    """News: the process says something."""

    text: str


class Exited(_News, frozen=True):
    """News: the process is gone; the exit code is negative for a signal."""

    code: Annotated[int, Meta(ge=-64, le=255)]
    cpu_s: Annotated[float, Meta(ge=0, le=1e9)]
    max_rss_mb: Annotated[float, Meta(ge=0, le=1e9)]
    why: str = ""  # where the exit code does not say it


Request = Start | Signal | Store | Beat
News = Started | ProcessReport | Exited

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


MODULES: Sequence[str] = (
    "numpy",
    "protocol.bus.zenoh",
    "agents.process",
    "world.process",
    "deploy.processes.router",
)
_CLOSING = 5.0  # s


def environment() -> dict[str, str]:
    """Of a fork server. Robots are one thread each: more would only cost memory, and forks dislike them."""
    return {**os.environ, "OPENBLAS_NUM_THREADS": "1"}


class Spawner:
    """A fork server of one's own. `close` kills whatever was started and still runs.

    Raises:
        ProcessError: the fork server is gone; its own words are on standard error.
    """

    def __init__(
        self,
        modules: Sequence[str] = MODULES,
        run: str = "",
        logs: Path | None = None,
        lives: Iterator[int] | None = None,
    ) -> None:
        """Start the fork server, with `modules` imported, without waiting for it; titles name the `run`.

        Processes log to files in the folder `logs`. `lives` are numbers that no other process has or had.
        """
        ours, theirs = socket.socketpair()
        with theirs:
            self._server = self._serve(theirs, modules, run, logs)
        self._channel: Channel[Request, Any] = Channel(ours.detach())
        self._lives = count(1) if lives is None else lives
        self.gone = False  # the fork server ended by itself, and this was said once

    def _serve(
        self, theirs: socket.socket, modules: Sequence[str], run: str, logs: Path | None
    ) -> subprocess.Popen[bytes]:
        """Start the fork server at the other end of the channel."""
        code = (
            f"import sys; sys.path[:] = {sys.path!r}; "
            "from deploy.processes.fork_server import main; "
            f"main({theirs.fileno()}, {tuple(modules)!r}, {run!r}, {'' if logs is None else str(logs)!r})"
        )
        return subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=subprocess.DEVNULL,
            stdout=2,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
            env=environment(),
        )

    def start(self, process: Process) -> int:
        """Ask for a process; returns the number of its life."""
        life = next(self._lives)
        self._send(Start(life, process))
        return life

    def signal(self, life: int, number: int) -> None:
        """Send a signal; nothing happens if that process has ended."""
        self._send(Signal(life, number))

    def news(self, timeout: float) -> Iterator[News]:
        """What happened; waits at most `timeout` s for the first of it."""
        try:
            while self._channel.poll(timeout):
                yield decode_news(self._channel.recv_bytes(MAX_NEWS))
                timeout = 0.0
        except (EOFError, ConnectionError):
            raise self._gone() from None

    def fileno(self) -> int:
        """What is readable when there is news."""
        return self._channel.fileno()

    def hang_up(self) -> None:
        """Have the fork server end, and with it every process, without waiting for that."""
        self._channel.close()

    def close(self) -> None:
        """End the fork server, and with it every process; may be called twice."""
        self.hang_up()
        try:
            self._server.wait(_CLOSING)
        except subprocess.TimeoutExpired:
            self._server.kill()
            self._server.wait()

    def _send(self, request: Request) -> None:
        try:
            self._channel.send(request)
        except ConnectionError:
            raise self._gone() from None

    def _gone(self) -> ProcessError:
        self.gone = True
        return ProcessError(
            f"the fork server (process {self._server.pid}), and with it every process of the fleet, is gone; "
            f"see its output above"
        )
