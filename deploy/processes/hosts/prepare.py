"""Checks of a host before a run."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import closing
from functools import partial

from deploy.processes.hosts.ssh import OtherVersionError, SshSpawner
from deploy.processes.hosts.table import Host
from deploy.processes.spawn import HostFacts, Spawner
from deploy.software import Finding
from protocol.errors import ProcessError

_PATIENCE = 60.0  # s for a host to answer
_SPAN = 2.0  # s between two readings of its clock
_LOOKS = 5  # requests per reading; the quickest answer is used
_RATE = 1e-3  # largest relative error of its clock's rate
_SPACE = 200 * 2**20  # bytes


def check(host: Host) -> list[Finding]:
    """Check reach, version, clock, router port and space, over the connection that a run would use; stops
    after an unreachable host, or another version.
    """
    began = time.monotonic()
    try:
        with closing(SshSpawner(host, "") if host.ssh else Spawner()) as spawner:
            if isinstance(spawner, SshSpawner):
                spawner.greet(_PATIENCE)
            look = partial(spawner.look, host.listen or host.address, host.port, _PATIENCE)
            facts = look()
            reach = Finding("reach", "good", f"answers after {time.monotonic() - began:.1f} s")
            fine = facts.free >= _SPACE
            space = Finding("space", "good" if fine else "bad", f"{facts.free / 2**30:.1f} GiB")
            return [reach, *_software(facts), _clock(look), _port(host, facts), space]
    except ProcessError as error:
        return [Finding("version" if isinstance(error, OtherVersionError) else "reach", "bad", str(error))]


def _software(facts: HostFacts) -> list[Finding]:
    compiled = "yes" if facts.compiled else "no: its robots take about five times as long"
    return [
        Finding("version", "good", f"same as here, Python {facts.python}"),
        Finding("compiled", "good" if facts.compiled else "note", compiled),
    ]


def _clock(look: Callable[[], HostFacts]) -> Finding:
    """Difference of the clock rates, with an error bounded by the round-trip times."""
    first, error = _offset(look)
    began = time.monotonic()
    time.sleep(_SPAN)
    second, later_error = _offset(look)
    span = time.monotonic() - began
    rate, error = (second - first) / span, (error + later_error) / span
    fine, text = abs(rate) <= _RATE + error, f"{1e6 * rate:+.0f} ± {1e6 * error:.0f} ppm"
    return Finding("clock rate", "good" if fine else "bad", text)


def _offset(look: Callable[[], HostFacts]) -> tuple[float, float]:
    looks = []
    for _ in range(_LOOKS):
        asked = time.monotonic()
        theirs = look().now
        answered = time.monotonic()
        looks.append(((answered - asked) / 2.0, theirs - (asked + answered) / 2.0))
    error, offset = min(looks)
    return offset, error


def _port(host: Host, facts: HostFacts) -> Finding:
    where = f"port {host.port} at {host.address}"
    if facts.port:
        return Finding("router port", "bad", f"{where}: {facts.port}")
    try:
        socket.create_connection((host.address, host.port), 5.0).close()
    except OSError as error:
        return Finding("router port", "bad", f"{where} cannot be reached from here: {error}")
    return Finding("router port", "good", f"{where} is free, and can be reached from here")
