"""How a scenario is run: everything that is not part of the scenario itself."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from protocol.errors import UsageError

Transport = Literal["routed", "mesh", "local"]
Mode = Literal["lockstep", "realtime"]


def fresh_run_name() -> str:
    """A run name that no other fleet on this network has."""
    return f"run-{os.urandom(4).hex()}"


@dataclass(frozen=True)
class RunOptions:
    """Transport, clock and names of a run."""

    transport: Transport = "routed"
    mode: Mode = "lockstep"
    router: str | None = None  # endpoint of a router that is already there
    run: str = field(default_factory=fresh_run_name)
    secure: Path | None = None  # directory of keys; every link is TLS with certificates then
    speed: float = 0.0  # simulated seconds per second in lock-step; 0: as fast as the machine allows

    def __post_init__(self) -> None:
        if self.secure is not None and self.transport != "routed":
            raise UsageError(f"--secure needs --transport routed: nobody enforces rules in {self.transport}")

    @property
    def lockstep(self) -> bool:
        """Whether the world waits for every robot."""
        return self.mode == "lockstep"
