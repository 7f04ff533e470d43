"""Options of a run that are not part of its scenario."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

from deploy.processes.hosts.table import HostsTable, exposed
from deploy.telemetry.recording.writer import ONE_FILE, Rotation
from protocol.errors import UsageError

Transport = Literal["routed", "mesh", "local"]
Mode = Literal["lockstep", "realtime"]
RESTARTS = 3  # of the policy `on-failure` without a number
_POLICY = re.compile(r"never|on-failure(?::([1-9][0-9]{0,3}))?")


def fresh_run_name() -> str:

    return f"run-{os.urandom(4).hex()}"


def restarts(policy: str) -> int:
    """Number of restarts by the policy `never` or `on-failure[:N]`; raises UsageError for any other."""
    found = _POLICY.fullmatch(policy)
    if found is None:
        raise UsageError(f"--restart {policy!r}: give never, on-failure, or on-failure:N with N from 1 on")
    if policy == "never":
        return 0
    return int(found[1]) if found[1] else RESTARTS


@dataclass(frozen=True)
class RunOptions:
    """Transport, clock and names of a run."""

    transport: Transport = "routed"
    mode: Mode = "lockstep"
    router: str | None = None  # endpoint of a running router
    run: str = field(default_factory=fresh_run_name)
    secure: Path | None = None  # directory of keys; every link is then TLS with certificates
    hosts: HostsTable | None = None  # hosts of the processes; default this one
    open: bool = False  # allow hosts without keys that other machines can reach
    speed: float = 0.0  # simulated seconds per second in lock-step; 0: as fast as the machine allows
    restarts: int = 0  # restarts after failures of each robot, world or router
    log: Path | None = None  # folder of log files, one per process
    rotation: Rotation = ONE_FILE  # when a recording continues in another file
    listen: str | None = None  # endpoint of the started router; default a free port of this host

    def __post_init__(self) -> None:
        for name, value, known in (("transport", self.transport, Transport), ("mode", self.mode, Mode)):
            if value not in get_args(known):
                raise UsageError(f"{name} {value!r}: give {', '.join(get_args(known))}")
        if self.secure is not None and self.transport != "routed":
            raise UsageError(
                f"--secure needs --transport routed: no router enforces rules in transport {self.transport}"
            )
        if self.router is not None and self.transport != "routed":
            raise UsageError(f"--router needs --transport routed: transport {self.transport} has no router")
        if self.rotation != ONE_FILE and self.transport == "local":
            raise UsageError("--rotate needs a recorder process: leave out --transport local")
        if self.restarts and self.transport == "local":
            raise UsageError("--restart needs processes of their own: leave out --transport local")
        if self.hosts is not None and (self.transport != "routed" or self.router is not None):
            raise UsageError("--hosts starts a router on every host: leave out --transport and --router")
        if self.listen is not None and (self.transport != "routed" or self.router or self.hosts):
            raise UsageError(
                "--listen is for the one router that is started: leave out --transport, --router and --hosts"
            )
        if (
            self.hosts is not None
            and self.secure is None
            and not self.open
            and (names := exposed(self.hosts))
        ):
            raise UsageError(
                f"any process that reaches host {', '.join(names)} by the network could join the run: "
                f"--secure DIR with keys from `disknav setup keys DIR --hosts TABLE`, or --open to allow it"
            )

    @property
    def lockstep(self) -> bool:
        """Whether the world waits for every robot."""
        return self.mode == "lockstep"
