"""A host's fork server at the other end of an ssh connection; OpenSSH's own client makes that.

The connection may stall at any byte, and the host may have been taken over: messages are framed as by
`multiprocessing.connection` (a length in four bytes, big-endian, then the message), and what is said there is
labelled with the host's name.
"""

from __future__ import annotations

import logging
import os
import select
import shlex
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from math import inf
from pathlib import Path
from typing import IO

import msgspec

from deploy.processes.hosts.remote import GREETING
from deploy.processes.hosts.table import Host
from deploy.processes.spawn import (
    MAX_NEWS,
    Beat,
    Exited,
    News,
    Request,
    Spawner,
    Store,
    decode_news,
)
from deploy.software import SOFTWARE, code_digest
from protocol.codec import DAMAGED
from protocol.errors import ProcessError
from protocol.process.log import LOG, LogLine, Speaker, lines, words

_HEAD = struct.Struct("!i")
_CHUNK = 1 << 16  # bytes
_AT_ONCE = 256  # messages; so that one host that never stops talking does not keep others from being heard


class FramedMessages:
    """What comes out of `descriptor`, message by message, without ever waiting for the rest of one.

    Args:
        descriptor: is read from; stays its owner's.
        largest: bytes of a message, at most.
        patience: s that a message may take from its first byte to its last.
        clock: tells the time, s.
    """

    def __init__(
        self,
        descriptor: int,
        largest: int,
        patience: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._descriptor, self._largest, self._patience, self._clock = descriptor, largest, patience, clock
        self._buffer = bytearray()
        self._began = inf  # s, when a message began that is not complete

    def read(self, timeout: float) -> Iterator[bytes]:
        """What has arrived, after at most `timeout` s of waiting for it.

        Raises:
            EOFError: the connection has ended.
            ValueError: what comes is no message, or does not come to an end.
        """
        for _ in range(_AT_ONCE):
            message = self._complete()
            if message is None:
                if not select.select([self._descriptor], [], [], timeout)[0]:
                    break
                arrived = os.read(self._descriptor, _CHUNK)
                if not arrived:
                    raise EOFError
                self._buffer += arrived
            else:
                yield message
            timeout = 0.0
        self._check_patience()

    def _complete(self) -> bytes | None:
        """The first message in the buffer, once it is there as a whole."""
        if len(self._buffer) < _HEAD.size:
            return None
        (length,) = _HEAD.unpack_from(self._buffer)
        if not 0 <= length <= self._largest:
            raise ValueError(f"a message of {length} bytes")
        end = _HEAD.size + length
        if len(self._buffer) < end:
            return None
        message = bytes(self._buffer[_HEAD.size : end])
        del self._buffer[:end]
        self._began = inf
        return message

    def _check_patience(self) -> None:
        if not self._buffer:
            return
        now = self._clock()
        self._began = min(self._began, now)
        if now > self._began + self._patience:
            raise ValueError(f"it stalled in the middle of a message for {self._patience:g} s")


_LONGEST = 1 << 16  # bytes of a line that are read at once
_LAST_WORDS = 1.0  # s
_decoder = msgspec.json.Decoder(LogLine)


class Relay:
    """Takes what the processes of one host, its shell and ssh write to standard error.

    A host that was taken over can say what it likes here; it is labelled as that host's, and cannot steer
    the terminal.

    Raises:
        UsageError: nothing can be written to `folder`.
    """

    def __init__(self, host: str, run: str, folder: Path | None) -> None:
        self._host, self._speaker = host, Speaker(run, host)
        self._logger = logging.Logger(f"{LOG.name}.{host}")
        self._logger.addHandler(words(self._speaker))
        if folder is not None:
            self._logger.addHandler(lines(self._speaker, folder / f"{host}.jsonl"))
        self._thread: threading.Thread | None = None

    def follow(self, stream: IO[bytes]) -> None:
        """Take everything from `stream`, on a thread of its own."""
        self._thread = threading.Thread(
            target=self._read, args=(stream,), name=f"log of {self._host}", daemon=True
        )
        self._thread.start()

    def end(self) -> None:
        """Wait for the last words of a host that is gone."""
        if self._thread is not None:
            self._thread.join(_LAST_WORDS)

    def take(self, said: bytes) -> None:
        """Take one line: of a log, or plain text."""
        try:
            line = _decoder.decode(said)
            text = printable(line.text).replace("\n", f"\n{self._host}: ")
            record = msgspec.structs.replace(line, text=text).record(self._host)
        except DAMAGED:
            self._logger.warning(printable(said.decode(errors="replace")))
        else:
            self._logger.handle(record)

    def _read(self, stream: IO[bytes]) -> None:
        with stream:
            while said := stream.readline(_LONGEST):
                self.take(said)


def printable(said: str) -> str:
    """The text without what would steer a terminal; a traceback keeps its lines."""
    return "".join(each if each.isprintable() or each == "\n" else " " for each in said).rstrip()


BEAT = 1.0  # s between signs of life of this launcher
_STALL = 5.0  # s that a host may take over a message, of its own or to it
_LONGEST_LINE = 1 << 12  # bytes that a shell may say at login before it ends the line
_MISSING = 127  # exit status of a shell that does not find a command
# The first value that ssh is given counts, so a host's own options outrank these.
_OPTIONS = (
    "BatchMode=yes",  # no person is there to be asked for a password
    "ConnectTimeout=10",
    "ServerAliveInterval=2",  # a host that is silent this long, three times, is gone
    "ServerAliveCountMax=3",
    "ClearAllForwardings=yes",
    "LogLevel=ERROR",
)


def ssh_command(host: Host, there: str) -> list[str]:
    """The command line that has a shell on `host` run `there`, without asking for a password."""
    options = [word for option in _OPTIONS for word in ("-o", option)]
    return ["ssh", "-T", *host.options, *options, "--", host.ssh, there]


class SshSpawner(Spawner):
    """The fork server on `host`. Construction does not wait for it; `greet` does.

    Raises:
        ProcessError: there is no ssh here; or from any method, the host is gone.
    """

    def __init__(
        self,
        host: Host,
        run: str,
        logs: Path | None = None,
        lives: Iterator[int] | None = None,
    ) -> None:
        """Reach `host`; what is said there is relayed to the terminal, and to its file in `logs`."""
        self.host = host
        self.folder = ""  # on the host, for files; known once it has greeted
        self._beat = 0.0
        super().__init__(run=run, logs=logs, lives=lives)
        self._frames = FramedMessages(self._channel.fileno(), MAX_NEWS, _STALL)
        with socket.socket(fileno=os.dup(self._channel.fileno())) as ours:  # an option of both descriptors
            ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(_STALL), 0))

    def greet(self, timeout: float) -> None:
        """Wait until the host says that it serves.

        Raises:
            ProcessError: it does not, or is of other code; says which host and why.
        """
        deadline = time.monotonic() + timeout
        while not self.folder:
            line = self._line(deadline)
            words = line.split(maxsplit=2)
            if words[:1] != [GREETING]:
                self._relay.take(line.encode())  # what a shell says at login
            elif len(words) != 3 or words[1] != code_digest(SOFTWARE):
                raise ProcessError(
                    f"host {self.host.name}: {self.host.command} there is another version than this one; "
                    f"a fleet needs the same on every host"
                )
            else:
                self.folder = words[2]

    def close(self) -> None:
        """As of any fork server; what the host said last is waited for."""
        super().close()
        self._relay.end()

    def store(self, name: str, content: bytes) -> None:
        """Put a file into the host's folder, for its owner's eyes only; once."""
        self._send(Store(name, content))

    def news(self, timeout: float) -> Iterator[News]:
        """As of any fork server; a host that was taken over can say nothing but news."""
        now = time.monotonic()
        if now >= self._beat + BEAT:
            self._beat = now
            self._send(Beat())
        try:
            for message in self._frames.read(timeout):
                yield _checked(decode_news(message))
        except (EOFError, ConnectionError):
            raise self._gone() from None
        except (OSError, ValueError, *DAMAGED) as error:
            raise ProcessError(f"host {self.host.name} does not follow the protocol: {error}") from None

    def _send(self, request: Request) -> None:
        try:
            super()._send(request)
        except BlockingIOError:
            raise ProcessError(f"host {self.host.name} has accepted nothing for {_STALL:g} s") from None

    def _serve(
        self, theirs: socket.socket, modules: Sequence[str], run: str, logs: Path | None
    ) -> subprocess.Popen[bytes]:
        del modules  # the host knows them
        self._relay = Relay(self.host.name, run, logs)
        command = ssh_command(self.host, f"{self.host.command} node host --run={shlex.quote(run)}")
        end = theirs.fileno()
        try:
            ssh = subprocess.Popen(
                command, stdin=end, stdout=end, stderr=subprocess.PIPE, start_new_session=True
            )
        except FileNotFoundError:
            raise ProcessError("hosts are reached by OpenSSH, and there is no command ssh here") from None
        assert ssh.stderr is not None
        self._relay.follow(ssh.stderr)
        return ssh

    def _line(self, deadline: float) -> str:
        """A line of text, byte by byte: what follows the greeting is not text."""
        descriptor = self._channel.fileno()
        line = b""
        while not line.endswith(b"\n"):
            readable, _, _ = select.select([descriptor], [], [], max(0.0, deadline - time.monotonic()))
            if not readable:
                raise ProcessError(f"host {self.host.name} did not answer in time")
            byte = os.read(descriptor, 1)
            if not byte:
                raise self._gone()
            line += byte
            if len(line) > _LONGEST_LINE:
                raise ProcessError(f"host {self.host.name} does not follow the protocol: no end of a line")
        return line.decode(errors="replace").rstrip("\n")

    def _gone(self) -> ProcessError:
        self.gone = True
        try:
            status = self._server.wait(5.0)
        except subprocess.TimeoutExpired:
            return ProcessError(f"host {self.host.name} closed the connection")
        self._relay.end()
        if status == _MISSING:
            return ProcessError(f"host {self.host.name}: the shell there finds no {self.host.command!r}")
        how = f"with status {status}; see its output above" if status >= 0 else f"by signal {-status}"
        return ProcessError(f"host {self.host.name} is gone: ssh ended {how}")


def _checked(news: News) -> News:
    """Raises ValueError if this is nothing that a fork server says; why a process ended, launchers say."""
    if isinstance(news, Exited) and news.why:
        raise ValueError("it says why a process ended")
    return news
