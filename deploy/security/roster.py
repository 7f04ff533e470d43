"""The roster of a run: its name, its robots, and the role that each certificate stands for."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

import msgspec

from protocol.errors import CertificateError
from protocol.keys import checked_run

ROSTER = "roster.json"
WORLD, ROUTER, MONITOR = "world", "router", "monitor"


@dataclass(frozen=True, slots=True)
class Roster:
    """Who takes part in `run`. A role is the common name of exactly one certificate."""

    run: str
    robots: tuple[int, ...]

    @property
    def roles(self) -> tuple[str, ...]:
        """Every role: router, world, monitor, then `robot-1` and so on."""
        return (ROUTER, WORLD, MONITOR, *map(robot_role, self.robots))


def robot_role(robot: int) -> str:
    """Role of one robot, `robot-3`."""
    return f"robot-{robot}"


def encoded(roster: Roster) -> bytes:
    """The roster as its file has it."""
    return msgspec.json.format(msgspec.json.encode(asdict(roster))) + b"\n"


def read(directory: Path) -> Roster:
    """The roster in a directory of keys.

    Raises:
        CertificateError: there is none, or it cannot be read as one.
    """
    path = directory / ROSTER
    try:
        roster = msgspec.json.decode(path.read_bytes(), type=Roster)
    except FileNotFoundError:
        raise CertificateError(
            f"{path} does not exist: {directory} is no directory of keys; "
            f"`disknav keys new {directory} --scenario S` makes one"
        ) from None
    except (OSError, msgspec.DecodeError) as error:
        raise CertificateError(f"{path} cannot be read as a roster: {error}") from error
    checked_run(roster.run)
    return roster
