"""The roster of a run: its name, its robots, its hosts, and the role that each certificate stands for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

import msgspec

from protocol.codec import DAMAGED
from protocol.errors import CertificateError
from protocol.keys import checked_run

ROSTER = "roster.json"
WORLD, ROUTER, MONITOR, OPERATOR = "world", "router", "monitor", "operator"


@dataclass(frozen=True, slots=True)
class Home:
    """A host with a router of its own: where that is reached, and the robots behind it."""

    addresses: tuple[str, ...]  # names or addresses, without a port
    robots: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Roster:
    """Who takes part in `run`, and where. A role is the common name of exactly one certificate.

    Without `homes` there is one router for all.
    """

    run: str
    robots: tuple[int, ...]
    homes: Mapping[str, Home] = field(default_factory=dict)  # by name of the host
    world: str = ""  # the host behind whose router are the world and whoever watches

    @property
    def routers(self) -> tuple[str, ...]:
        """Roles of the routers: `router`, or `router-left` and so on."""
        return tuple(map(router_role, self.homes)) or (ROUTER,)

    @property
    def roles(self) -> tuple[str, ...]:
        """Every role: routers, world, monitor, operator, then `robot-1` and so on."""
        return (*self.routers, WORLD, MONITOR, OPERATOR, *map(robot_role, self.robots))

    def behind(self, host: str) -> tuple[str, ...]:
        """Roles whose processes are clients of the router of `host`.

        Raises:
            CertificateError: the run has no such host.
        """
        if host not in self.homes:
            raise CertificateError(
                f"the keys of the run {self.run} are not for a host {host!r}, "
                f"but for {', '.join(self.homes) or 'one router'}"
            )
        others = (WORLD, MONITOR, OPERATOR) if host == self.world else ()
        return (*others, *map(robot_role, self.homes[host].robots))


def robot_role(robot: int) -> str:
    """Role of one robot, `robot-3`."""
    return f"robot-{robot}"


def router_role(host: str = "") -> str:
    """Role of the router of a host, `router-left`; `router` where there is one for all."""
    return f"{ROUTER}-{host}" if host else ROUTER


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
            f"`disknav setup keys {directory} --scenario S` makes one"
        ) from None
    except (OSError, *DAMAGED) as error:
        raise CertificateError(f"{path} cannot be read as a roster: {error}") from error
    checked_run(roster.run)
    return roster
