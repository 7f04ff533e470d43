"""What one call of `disknav study` asks for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from deploy.output.json_output import is_standard_output
from deploy.run.options import Transport
from deploy.studies.harness.study import StudyName


@dataclass(frozen=True)
class Request:
    """What the command line asked for."""

    name: StudyName
    runs: int | None
    jobs: int
    scheduler: str | None
    seed: int
    settings: tuple[str, ...]
    transport: Transport | None
    target: Path | None
    plot: Path | None
    fresh: bool
    quiet: bool
    laws: tuple[str, ...] = ()
    only: tuple[str, ...] = ()

    @property
    def file(self) -> Path | None:
        """The file to write, if it is one."""
        return None if is_standard_output(self.target) else self.target
