"""A host's fork server at the other end of an ssh connection of OpenSSH's client.

The connection may stall at any byte, and an attacker may control the host: messages are framed as by
`multiprocessing.connection` (a length in four bytes, big-endian, then the message), and text from the host is
labelled with its name.
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
from collections.abc import Callable, Iterator
from math import inf
from pathlib import Path
from typing import IO

import msgspec

from deploy.processes.hosts.remote import GREETING
from deploy.processes.hosts.table import Host
from deploy.processes.spawn import (
    BEAT,
    MAX_NEWS,
    Beat,
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
_AT_ONCE = 256  # messages of one host, before the other hosts' turn


class FramedMessages:
    """Reads complete messages from a descriptor, without waiting for the rest of an incomplete one.

    Args:
        largest: size limit of a message, bytes.
        patience: longest time from the first byte of a message to its last, s.
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
        self._began = inf  # s, arrival of the first byte of an incomplete message

    def read(self, timeout: float) -> Iterator[bytes]:
        """Messages that have arrived; waits at most `timeout` s for the first.

        Raises EOFError at the end of the connection, ValueError if a message is invalid or incomplete for
        too long.
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


_LONGEST = 1 << 16  # bytes of a line read at once
_LAST_WORDS = 1.0  # s
_decoder = msgspec.json.Decoder(LogLine)


class Relay:
    """Relays the standard error of one host's processes, shell and ssh to log and terminal.

    Each line is labelled with the host's name, without terminal control sequences. Raises UsageError if
    `folder` cannot be written.
    """

    def __init__(self, host: str, run: str, folder: Path | None) -> None:
        self._host, self._speaker = host, Speaker(run, host)
        self._logger = logging.Logger(f"{LOG.name}.{host}")
        self._logger.addHandler(words(self._speaker))
        if folder is not None:
            self._logger.addHandler(lines(self._speaker, folder / f"{host}.jsonl"))
        self._thread: threading.Thread | None = None

    def follow(self, stream: IO[bytes]) -> None:
        """Relay `stream` in a thread of its own."""
        self._thread = threading.Thread(
            target=self._read, args=(stream,), name=f"log of {self._host}", daemon=True
        )
        self._thread.start()

    def end(self) -> None:
        """Wait for the last lines of a host that is gone."""
        if self._thread is not None:
            self._thread.join(_LAST_WORDS)

    def take(self, raw: bytes) -> None:
        """Relay one line: of a log, or plain text."""
        try:
            line = _decoder.decode(raw)
            text = printable(line.text).replace("\n", f"\n{self._host}: ")
            record = msgspec.structs.replace(line, text=text).record(self._host)
        except DAMAGED:
            self._logger.warning(printable(raw.decode(errors="replace")))
        else:
            self._logger.handle(record)

    def _read(self, stream: IO[bytes]) -> None:
        with stream:
            while raw := stream.readline(_LONGEST):
                self.take(raw)


def printable(raw: str) -> str:
    """The text without terminal control characters; line breaks stay."""
    return "".join(each if each.isprintable() or each == "\n" else " " for each in raw).rstrip()


_STALL = 5.0  # s for one message, from or to a host
_LONGEST_LINE = 1 << 12  # bytes of a line printed by a shell at login
_MISSING = 127  # exit status of a shell that does not find a command
# ssh uses the first value of an option, so a host's own options override these.
_OPTIONS = (
    "BatchMode=yes",  # no password prompts
    "ConnectTimeout=10",
    "ServerAliveInterval=2",  # three times this without an answer: the host is gone
    "ServerAliveCountMax=3",
    "ClearAllForwardings=yes",
    "LogLevel=ERROR",
)


class OtherVersionError(ProcessError):
    """A host has another version of this software."""


class SshSpawner(Spawner):
    """The fork server on another host. The constructor does not wait for it; `greet` does.

    Text from the host is relayed to the terminal, and to its file in `logs`. Raises ProcessError if this
    machine has no ssh; any method raises it once the host is lost.
    """

    def __init__(self, host: Host, run: str, logs: Path | None = None) -> None:
        self.host, self.name = host, f"host {host.name}"
        self._relay = Relay(host.name, run, logs)
        self.folder = ""  # for files on the host; known after `greet`
        self._beat = 0.0
        super().__init__(run=run)
        self._frames = FramedMessages(self._channel.fileno(), MAX_NEWS, _STALL)
        with socket.socket(fileno=os.dup(self._channel.fileno())) as ours:  # for both descriptors
            ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(_STALL), 0))

    def greet(self, timeout: float) -> None:
        """Wait for the host's greeting; raises ProcessError without one, or for another version."""
        deadline = time.monotonic() + timeout
        while not self.folder:
            line = self._line(deadline)
            words = line.split(maxsplit=2)
            if words[:1] != [GREETING]:
                self._relay.take(line.encode())  # printed by the shell at login
            elif len(words) != 3 or words[1] != code_digest(SOFTWARE):
                raise OtherVersionError(
                    f"{self.name}: its {self.host.command} is not the same version as this one; "
                    f"a fleet needs the same on every host"
                )
            else:
                self.folder = words[2]

    def close(self) -> None:
        """End the fork server; waits for the host's last lines."""
        super().close()
        self._relay.end()

    def store(self, path: Path) -> str:
        """Copy a file into the host's folder, with mode 0600, unless it is lost; returns the path there."""
        if not self.gone:
            self._send(Store(path.name, path.read_bytes()))
        return f"{self.folder}/{path.name}"

    def news(self, timeout: float) -> Iterator[News]:
        """`Spawner.news`; anything else from the host is an error."""
        now = time.monotonic()
        if now >= self._beat + BEAT:
            self._beat = now
            self._send(Beat())
        try:
            for message in self._frames.read(timeout):
                yield decode_news(message)
        except (EOFError, ConnectionError):
            raise self._gone() from None
        except (OSError, ValueError, *DAMAGED) as error:
            raise ProcessError(f"{self.name} does not follow the protocol: {error}") from None

    def _send(self, request: Request) -> None:
        try:
            super()._send(request)
        except BlockingIOError:
            raise ProcessError(f"{self.name} has accepted nothing for {_STALL:g} s") from None

    def _serve(self, theirs: socket.socket) -> subprocess.Popen[bytes]:
        there = f"{self.host.command} node host --run={shlex.quote(self._run)}"
        options = [word for option in _OPTIONS for word in ("-o", option)]
        command = ["ssh", "-T", *self.host.options, *options, "--", self.host.ssh, there]
        end = theirs.fileno()
        try:
            ssh = subprocess.Popen(
                command, stdin=end, stdout=end, stderr=subprocess.PIPE, start_new_session=True
            )
        except FileNotFoundError:
            raise ProcessError("no command ssh on this machine: install the OpenSSH client") from None
        assert ssh.stderr is not None
        self._relay.follow(ssh.stderr)
        return ssh

    def _line(self, deadline: float) -> str:
        """Read a line byte by byte, since binary messages follow it."""
        descriptor = self._channel.fileno()
        line = b""
        while not line.endswith(b"\n"):
            readable, _, _ = select.select([descriptor], [], [], max(0.0, deadline - time.monotonic()))
            if not readable:
                raise ProcessError(f"{self.name} did not answer in time")
            byte = os.read(descriptor, 1)
            if not byte:
                raise self._gone()
            line += byte
            if len(line) > _LONGEST_LINE:
                raise ProcessError(f"{self.name} does not follow the protocol: no end of a line")
        return line.decode(errors="replace").rstrip("\n")

    def _gone(self) -> ProcessError:
        self.gone = True
        try:
            status = self._server.wait(5.0)
        except subprocess.TimeoutExpired:
            return ProcessError(f"{self.name} closed the connection")
        self._relay.end()
        if status == _MISSING:
            return ProcessError(f"{self.name}: its shell finds no command {self.host.command!r}")
        said = "see its output above; if there is none, the host was cut off"
        how = f"with status {status}; {said}" if status >= 0 else f"by signal {-status}"
        return ProcessError(f"{self.name} is gone: ssh ended {how}")
