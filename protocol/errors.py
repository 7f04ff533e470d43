"""The one hierarchy of errors. Every message names what was wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class DisknavError(Exception):
    """Base of every error that this software raises on purpose."""


class Problem(NamedTuple):
    """One mistake in a file: where (`robots[2].start`) and what."""

    path: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}: {self.text}" if self.path else self.text


class DocumentError(DisknavError):
    """A file of the user is malformed; carries every problem found, not just the first."""

    def __init__(self, source: str, problems: Sequence[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        lines = "\n".join(f"  {problem}" for problem in self.problems)
        plural = "" if len(self.problems) == 1 else "s"
        super().__init__(f"{source}: {len(self.problems)} problem{plural}\n{lines}")


class ScenarioError(DocumentError):
    """A scenario is malformed."""


class HostsError(DocumentError):
    """A table of hosts is malformed, or does not match the scenario."""


class UsageError(DisknavError):
    """An argument or option is invalid, or cannot be combined with others."""


class MessageError(DisknavError):
    """A payload was refused; `reason` is one of a few stable words, counted per receiver."""

    def __init__(self, reason: str, text: str) -> None:
        self.reason = reason
        super().__init__(text)


class KeyGrammarError(UsageError):
    """A key expression does not follow the grammar of `protocol.keys`."""


class BusError(DisknavError):
    """The transport could not be opened, or a peer did not answer in time."""


class UnservedError(BusError):
    """As far as known no process serves the key of a request; it was not sent if it may be sent once only."""


class ListenError(BusError):
    """The process cannot listen on the given endpoint."""


class EndpointTakenError(ListenError):
    """Another process listens on the given endpoint."""


class RunTakenError(UsageError):
    """Another world of the same run is on the network."""


class LawError(UsageError):
    """A control law of the user's fails, or does not return a velocity."""


class CertificateError(BusError):
    """A certificate or private key is missing, exposed, or not accepted by the other end."""


class JoinError(DisknavError):
    """The world refused a robot: unknown id, or that id is already running. `robot` is 0 if not stated."""

    def __init__(self, text: str, robot: int = 0) -> None:
        super().__init__(text)
        self.robot = robot


class ProcessError(DisknavError):
    """A process of the fleet did not start, or ended when it should not have."""


class StartError(ProcessError):
    """A process of the fleet could not start, and reported the reason on standard error."""


class RecordingError(DisknavError):
    """A recording cannot be read, or contradicts its result."""


class CheckpointError(DisknavError):
    """A checkpoint cannot be continued: it is damaged, of another run, in use, or missing."""


class MapError(DocumentError):
    """A map, or another tool's file, cannot be read or is invalid."""
