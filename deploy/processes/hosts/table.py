"""The hosts table: which host runs what, and how it is reached. TOML in, or every problem at once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from annotated_types import Ge, Le, MinLen

from protocol.endpoint import DEFAULT_PORT, Endpoint
from protocol.errors import HostsError, Problem, UsageError
from protocol.scenario.checks.sound import Sound
from protocol.scenario.file import read_toml
from protocol.scenario.model import RobotId
from protocol.scenario.ranges import STRICT
from protocol.scenario.schema import typed
from protocol.scenario.shape import Document, Finding, keys_of, written

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9-]*")


@dataclass(frozen=True, slots=True)
class Host:
    """One host: its router, its robots, and how OpenSSH reaches it."""

    __pydantic_config__ = STRICT
    name: str
    address: str  # name or address at which the other hosts, and the launcher, reach its router
    port: Annotated[int, Ge(1), Le(65535)] = 7447  # of its router
    listen: str = ""  # address that its router listens on; `address` unless given
    robots: tuple[RobotId, ...] = ()
    ssh: str = ""  # destination as OpenSSH understands it; without it, the host is this machine
    options: tuple[str, ...] = ()  # for ssh, such as ["-p", "2222"]
    command: str = "disknav"  # how the shell there calls this software


@dataclass(frozen=True, slots=True)
class HostsTable:
    """All hosts of a run."""

    __pydantic_config__ = STRICT
    hosts: Annotated[tuple[Host, ...], MinLen(1)]
    world: str = ""  # name of the host that runs the world; the first unless given

    @property
    def world_host(self) -> Host:
        """Where the world runs."""
        return next((host for host in self.hosts if host.name == self.world), self.hosts[0])

    @property
    def has_this_machine(self) -> bool:
        """Whether this machine is one of them."""
        return not all(host.ssh for host in self.hosts)

    def host_of(self, robot: int) -> Host:
        """Where a robot runs.

        Raises:
            UsageError: on no host, as one that was added to the fleet.
        """
        for host in self.hosts:
            if robot in host.robots:
                return host
        raise UsageError(
            f"no host of the table ({', '.join(host.name for host in self.hosts)}) has robot {robot}: "
            f"`disknav node robot {robot} --run NAME --router ENDPOINT` on one of them starts it there"
        )


def read_hosts(path: Path, robots: Sequence[int], newcomers: Sequence[int] = ()) -> HostsTable:
    """Read the hosts table for a scenario with these robots; others that orders add may be in it, too.

    Raises:
        HostsError: with every problem, in the order of the file.
    """
    return parse_hosts(read_toml(path, HostsError), robots, str(path), newcomers)


def read_any_hosts(path: Path) -> HostsTable:
    """Read a table whatever the scenario: every robot that it names is taken to be one.

    Raises:
        HostsError: as `read_hosts`.
    """
    document = read_toml(path, HostsError)
    entries = document.get("hosts")
    named = (
        [each.get("robots") for each in entries if isinstance(each, dict)]
        if isinstance(entries, list)
        else []
    )
    robots = {robot for each in named if isinstance(each, list) for robot in each if isinstance(robot, int)}
    return parse_hosts(document, sorted(robots), str(path))


def parse_hosts(
    document: Document, robots: Sequence[int], source: str = "hosts", newcomers: Sequence[int] = ()
) -> HostsTable:
    """The same from plain tables, as tomllib makes them."""
    table, findings = typed(document, HostsTable)
    findings += _checked(Sound(document, [steps for steps, _ in findings]), robots, newcomers)
    if table is not None and not findings:
        return table
    findings.sort(key=_file_order)
    raise HostsError(source, [Problem(written(steps), text) for steps, text in findings])


def _file_order(finding: Finding) -> tuple[tuple[int, str], ...]:
    steps, _ = finding
    top = list(keys_of(HostsTable))
    rank = top.index(str(steps[0])) if steps and steps[0] in top else -1
    rest = steps[1:]
    return ((rank, ""), *((step, "") if isinstance(step, int) else (-1, step) for step in rest))


def _checked(sound: Sound, robots: Sequence[int], newcomers: Sequence[int]) -> Iterator[Finding]:
    """Names and endpoints that are unique, options that are what they seem, every robot on one host."""
    names: dict[str, int] = {}
    endpoints: dict[tuple[str, int], int] = {}
    homes: dict[int, int] = {}
    for n in range(sound.size("hosts")):
        yield from _host(sound, n, names, endpoints)
        yield from _robots(sound, n, (*robots, *newcomers), homes)
    missing = [robot for robot in robots if robot not in homes]
    if missing and _all_robots_known(sound):
        plural = "" if len(missing) == 1 else "s"
        yield ("hosts",), f"robot{plural} {', '.join(map(str, missing))} of the scenario must be on a host"
    world = sound.get("world", default="")
    if world and world not in names:
        yield ("world",), f"there is no host {world!r}; there are {', '.join(names)}"


def _host(
    sound: Sound, n: int, names: dict[str, int], endpoints: dict[tuple[str, int], int]
) -> Iterator[Finding]:
    name = sound.get("hosts", n, "name")
    if name is not None:
        if not _NAME.fullmatch(name):
            yield ("hosts", n, "name"), "must be of letters, digits and '-', and not begin with '-'"
        elif names.setdefault(name, n) != n:
            yield ("hosts", n, "name"), f"is the name of hosts[{names[name]}] already"
    for key in ("address", "listen"):
        where = sound.get("hosts", n, key, default="")
        try:
            Endpoint.at("tcp", where or "localhost", DEFAULT_PORT)
        except UsageError:
            yield ("hosts", n, key), "must be a name or an address, without protocol, port or path"
    address, port = sound.get("hosts", n, "address"), sound.get("hosts", n, "port", default=7447)
    if address == "":
        yield ("hosts", n, "address"), "must not be empty"
    elif address is not None and port is not None and endpoints.setdefault((address, port), n) != n:
        other = endpoints[address, port]
        yield ("hosts", n, "port"), f"hosts[{other}] has its router at {address}, port {port} already"
    if (sound.get("hosts", n, "ssh", default="") or "").startswith("-"):
        yield ("hosts", n, "ssh"), "must be a destination such as user@host; options go into `options`"
    if sound.get("hosts", n, "command") == "":
        yield ("hosts", n, "command"), "must not be empty"


def _robots(sound: Sound, n: int, robots: Sequence[int], homes: dict[int, int]) -> Iterator[Finding]:
    for m in range(sound.size("hosts", n, "robots")):
        robot = sound.get("hosts", n, "robots", m)
        if robot is None:
            continue
        if robot not in robots:
            yield ("hosts", n, "robots", m), f"the scenario has no robot {robot}"
        elif robot in homes:
            yield ("hosts", n, "robots", m), f"robot {robot} is on hosts[{homes[robot]}] already"
        else:
            homes[robot] = n


def _all_robots_known(sound: Sound) -> bool:
    """Whether nothing that is malformed could hide a robot."""
    count = sound.size("hosts")
    return count > 0 and all(sound.get("hosts", n, "robots", default=()) is not None for n in range(count))
