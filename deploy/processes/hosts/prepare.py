"""Checks of a host before a run."""

from __future__ import annotations

import os
import select
import shlex
import socket
import subprocess
import sys
import time

import msgspec

from deploy.processes.hosts.remote import Facts
from deploy.processes.hosts.ssh import ssh_command
from deploy.processes.hosts.table import Host
from deploy.processes.spawn import environment
from deploy.software import SOFTWARE, Finding, code_digest
from protocol.codec import DAMAGED

_PATIENCE = 60.0  # s for a host to answer
_SPAN = 2.0  # s between two readings of its clock
_LOOKS = 5  # requests per reading; the quickest answer is used
_RATE = 1e-3  # largest relative error of its clock's rate
_SPACE = 200 * 2**20  # bytes
_LONGEST = 1 << 16  # bytes of an answer


class _SilentError(Exception):
    """The host gives no valid answer; the text tells how."""


def check(host: Host) -> list[Finding]:
    """Check reach, version, clock, router port and space; stops after an unreachable host."""
    listen = host.listen or host.address
    arguments = ["node", "host", "--facts", listen, str(host.port)]
    if host.ssh:
        command = ssh_command(host, f"{host.command} {shlex.join(arguments)}")
    else:
        command = [sys.executable, "-m", "deploy.processes.hosts.remote", "--facts", listen, str(host.port)]
    began = time.monotonic()
    try:
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment()
        ) as process:
            try:
                return _looked(host, process, began)
            finally:
                process.kill()
    except FileNotFoundError as error:
        return [Finding("reach", "bad", f"no command {error.filename} on this machine")]


def _looked(host: Host, process: subprocess.Popen[bytes], began: float) -> list[Finding]:
    try:
        facts = _facts(process)
        reach = Finding("reach", "good", f"answers after {time.monotonic() - began:.1f} s")
        return [reach, *_software(host, facts), _clock(process), _port(host, facts), _space(facts)]
    except _SilentError as error:
        return [Finding("reach", "bad", str(error))]


def _facts(process: subprocess.Popen[bytes]) -> Facts:
    said, deadline = b"", time.monotonic() + _PATIENCE
    while True:
        line = _line(process, deadline)
        try:
            return msgspec.json.decode(line, type=Facts)
        except DAMAGED:
            said += line  # printed by the shell at login
            if len(said) > _LONGEST:
                raise _SilentError("its output contains no valid answer") from None


def _line(process: subprocess.Popen[bytes], deadline: float) -> bytes:
    """Next line of the process's output until `deadline` (s, monotonic)."""
    assert process.stdout is not None
    line = b""
    while not line.endswith(b"\n"):
        if not select.select([process.stdout], [], [], max(0.0, deadline - time.monotonic()))[0]:
            raise _SilentError(f"no answer within {_PATIENCE:g} s")
        byte = os.read(process.stdout.fileno(), 1)
        if not byte or len(line) > _LONGEST:
            raise _SilentError(_last_words(process))
        line += byte
    return line


def _last_words(process: subprocess.Popen[bytes]) -> str:
    assert process.stderr is not None
    process.kill()
    said = process.stderr.read().decode(errors="replace").strip().splitlines()
    return said[-1] if said else "the connection ended without an error message"


def _software(host: Host, facts: Facts) -> list[Finding]:
    same = facts.code == code_digest(SOFTWARE)
    version = f"same as here, Python {facts.python}" if same else f"not the same as here: {host.command}"
    compiled = "yes" if facts.compiled else "no: its robots take three to four times as long"
    return [
        _finding("version", version, fine=same),
        Finding("compiled", "good" if facts.compiled else "note", compiled),
    ]


def _clock(process: subprocess.Popen[bytes]) -> Finding:
    """Difference of the clock rates, with an error bounded by the round-trip times."""
    first, error = _offset(process)
    began = time.monotonic()
    time.sleep(_SPAN)
    second, later_error = _offset(process)
    span = time.monotonic() - began
    rate, error = (second - first) / span, (error + later_error) / span
    return _finding(
        "clock rate", f"{1e6 * rate:+.0f} ± {1e6 * error:.0f} ppm", fine=abs(rate) <= _RATE + error
    )


def _offset(process: subprocess.Popen[bytes]) -> tuple[float, float]:
    assert process.stdin is not None
    looks = []
    for _ in range(_LOOKS):
        asked = time.monotonic()
        try:
            process.stdin.write(b"\n")
            process.stdin.flush()
            theirs = float(_line(process, asked + _PATIENCE))
        except (OSError, ValueError) as error:
            raise _SilentError(f"it does not report its time: {error}") from None
        answered = time.monotonic()
        looks.append(((answered - asked) / 2.0, theirs - (asked + answered) / 2.0))
    error_, offset = min(looks)
    return offset, error_


def _port(host: Host, facts: Facts) -> Finding:
    where = f"port {host.port} at {host.address}"
    if facts.port:
        return Finding("router port", "bad", f"{where}: {facts.port}")
    try:
        socket.create_connection((host.address, host.port), 5.0).close()
    except OSError as error:
        return Finding("router port", "bad", f"{where} cannot be reached from here: {error}")
    return Finding("router port", "good", f"{where} is free, and can be reached from here")


def _space(facts: Facts) -> Finding:
    return _finding("space", f"{facts.free / 2**30:.1f} GiB", fine=facts.free >= _SPACE)


def _finding(what: str, text: str, *, fine: bool) -> Finding:
    return Finding(what, "good" if fine else "bad", text)
