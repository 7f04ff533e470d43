"""Starting processes quickly and without orphans: the supervisor's side of the fork server, and its messages.

A fork costs a fraction of the time and memory of `multiprocessing`'s fork server, and much less than one
interpreter per process, as circus, supervisord and subprocess start it. The fork server leads its own
session, so a terminal's Ctrl-C reaches the supervisor only.

Requests are pickled. News are not, since they may come from another host, which must not be able to run code
here if an attacker controls it.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from multiprocessing.connection import Connection as Channel
from pathlib import Path
from signal import SIGCONT
from typing import Annotated, Any, NamedTuple

import msgspec
from msgspec import Meta

from protocol.errors import ProcessError
from protocol.process.log import LOG
from protocol.process.signals import STOP

_LEAST = 2  # robots per core from which they are pinned


def stay_on(core: int) -> None:
    """Pin this process to one processor core; Linux only. Call it before other threads start."""
    try:
        os.sched_setaffinity(0, {core})
    except OSError as error:  # refused by a sandbox, or the container has lost the core: only slower
        LOG.info(f"does not stay on core {core}: {error}")


def core_of(turn: int, robots: int) -> int | None:
    """Processor core for a robot's process; None to leave the choice to the system.

    The threads of a robot, and robots that wait for each other, run in turn. The system would move them to
    whichever core is idle, away from their cached data; on two busy cores, pinning saves 15 % of a tick with
    16 or 32 robots. `turn` is the index of the robot in the fleet.
    """
    if sys.platform != "linux":
        return None
    cores = sorted(os.sched_getaffinity(0))
    return cores[turn % len(cores)] if robots >= _LEAST * len(cores) else None


@dataclass(frozen=True, slots=True)
class Process:
    """One row of the table: a process to start, and the consequences of its end."""

    name: str  # unique in a fleet, such as `robot-3`
    entry: str  # "module:function"; it returns the exit status
    arguments: tuple[Any, ...] = ()  # picklable
    vital: bool = False  # the fleet cannot go on without it
    restarts: int = 0  # number of automatic restarts after failures
    reports: bool = False  # one more argument follows: a callable that sends text to the supervisor
    core: int | None = None  # processor core to pin it to; None: chosen by the system
    patience: float = 5.0  # s from SIGTERM to SIGKILL


class Start(NamedTuple):
    """Request: fork a process."""

    life: int  # number of this process, never used again
    process: Process


class Signal(NamedTuple):
    """Request: send a signal; ignored if the process has ended."""

    life: int
    number: int


class Store(NamedTuple):
    """Request to a fork server on another host: write a file into its folder, readable by its owner only."""

    name: str
    content: bytes


class Beat(NamedTuple):
    """Request: heartbeat of the supervisor."""


BEAT = 1.0  # s between heartbeats


class Look(NamedTuple):
    """Request: tell facts about this host, whose router is to listen on this address and port."""

    listen: str
    port: int


class _News(msgspec.Struct, frozen=True, tag=True, array_like=True, forbid_unknown_fields=True):
    """Base of the fork server's messages; `life` is the number of the process."""

    life: int


class Started(_News, frozen=True):
    """News: the process exists."""

    pid: Annotated[int, Meta(ge=1, lt=1 << 31)]


class ProcessReport(_News, frozen=True):
    """News: a text from the process."""

    text: str


class Exited(_News, frozen=True):
    """News: the process has ended; a negative exit code is a signal."""

    code: Annotated[int, Meta(ge=-64, le=255)]
    cpu_s: Annotated[float, Meta(ge=0, le=1e9)]
    max_rss_mb: Annotated[float, Meta(ge=0, le=1e9)]


class HostFacts(_News, frozen=True):
    """News: facts about the host; of no process."""

    python: str
    compiled: bool
    free: Annotated[int, Meta(ge=0)]  # bytes, where a run's files go
    port: str  # error on listening on the router's port; empty if there is none
    now: Annotated[float, Meta(ge=0, le=1e12)]  # s, monotonic


Request = Start | Signal | Store | Beat | Look
News = Started | ProcessReport | Exited | HostFacts

MAX_NEWS = 1 << 23  # bytes; twice the largest result

encode_news: Callable[[News], bytes] = msgspec.msgpack.Encoder().encode
decode_news: Callable[[bytes], News] = msgspec.msgpack.Decoder(News).decode  # raises `protocol.codec.DAMAGED`


MODULES: Sequence[str] = (
    "numpy",
    "protocol.bus.zenoh",
    "agents.process",
    "world.process",
    "deploy.processes.router",
)
_CLOSING = 5.0  # s


def environment() -> dict[str, str]:
    """Environment of a fork server: one OpenBLAS thread, as more cost memory and make forking unsafe."""
    return {**os.environ, "OPENBLAS_NUM_THREADS": "1"}


class Spawner:
    """A fork server of this process, which imports `modules` before the first fork. `close` kills all
    processes it has started.
    Methods raise ProcessError once the fork server is gone; its output is on standard error.
    """

    name = "this host"

    def __init__(self, modules: Sequence[str] = MODULES, run: str = "", logs: Path | None = None) -> None:
        self._modules, self._run, self._logs = modules, run, "" if logs is None else str(logs)
        ours, theirs = socket.socketpair()
        with theirs:
            self._server = self._serve(theirs)
        self._channel: Channel[Request, Any] = Channel(ours.detach())
        self._lives = count(1)
        self.gone = False  # the fork server has ended by itself

    def _serve(self, theirs: socket.socket) -> subprocess.Popen[bytes]:
        code = (
            f"import sys; sys.path[:] = {sys.path!r}; "
            "from deploy.processes.fork_server import main; "
            f"main({theirs.fileno()}, {tuple(self._modules)!r}, {self._run!r}, {self._logs!r})"
        )
        with STOP.held():  # signals from before it listens
            return subprocess.Popen(
                [sys.executable, "-c", code],
                stdin=subprocess.DEVNULL,
                stdout=2,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
                env=environment(),
            )

    def start(self, process: Process) -> int:
        """Request a process; returns its number."""
        life = next(self._lives)
        self._send(Start(life, process))
        return life

    def signal(self, life: int, number: int) -> None:
        """Send a signal, also if the fork server is frozen; ignored if the process has ended."""
        self._server.send_signal(SIGCONT)
        self._send(Signal(life, number))

    def news(self, timeout: float) -> Iterator[News]:
        """Messages of the fork server; waits at most `timeout` s for the first."""
        try:
            while self._channel.poll(timeout):
                yield decode_news(self._channel.recv_bytes(MAX_NEWS))
                timeout = 0.0
        except (EOFError, ConnectionError):
            raise self._gone() from None

    def look(self, listen: str, port: int, timeout: float) -> HostFacts:
        """Facts about the host, while no process runs; raises ProcessError after `timeout` s."""
        self._send(Look(listen, port))
        deadline = time.monotonic() + timeout
        while (remaining := deadline - time.monotonic()) > 0.0:
            for news in self.news(remaining):
                if isinstance(news, HostFacts):
                    return news
        raise ProcessError(f"no answer within {timeout:g} s")

    def fileno(self) -> int:
        """Descriptor that is readable when there are messages."""
        return self._channel.fileno()

    def hang_up(self) -> None:
        """Close the channel, which ends the fork server and all its processes, without waiting."""
        self._channel.close()

    def close(self) -> None:
        """End the fork server and all its processes; may be called twice."""
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
