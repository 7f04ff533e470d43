"""The table of hosts: processes of each host, its ssh destination, and its keys."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from deploy.security.roster import Home, KeyRoster
from protocol.bus.connection import DEFAULT_PORT, Endpoint, is_loopback
from protocol.errors import CertificateError, HostsError, Problem, UsageError
from protocol.scenario.body import RobotId
from protocol.scenario.file import read_document
from protocol.scenario.model import Scenario
from protocol.scenario.tables import Document, Mistake, Steps, file_order, read_table, written

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9-]*")


@dataclass(frozen=True, slots=True)
class Host:
    """One host: its router, its robots, and its ssh destination."""

    name: str
    address: str  # name or address of its router, for the other hosts and the launcher
    port: Annotated[int, Meta(ge=1, le=65535)] = 7447  # of its router
    listen: str = ""  # address on which its router listens; default `address`
    robots: tuple[RobotId, ...] = ()
    ssh: str = ""  # destination for OpenSSH; "": this machine
    options: tuple[str, ...] = ()  # for ssh, such as ["-p", "2222"]
    command: str = "disknav"  # command of this software in its shell


@dataclass(frozen=True, slots=True)
class HostsTable:
    """All hosts of a run."""

    hosts: Annotated[tuple[Host, ...], Meta(min_length=1)]
    world: str = ""  # name of the host that runs the world; default the first

    @property
    def world_host(self) -> Host:
        """Host that runs the world."""
        return next((host for host in self.hosts if host.name == self.world), self.hosts[0])

    def host_of(self, robot: int) -> Host:
        """Host that runs a robot; raises UsageError for a robot that was added to the fleet."""
        for host in self.hosts:
            if robot in host.robots:
                return host
        raise UsageError(
            f"no host of the table ({', '.join(host.name for host in self.hosts)}) runs robot {robot}: "
            f"`disknav node robot {robot} --run NAME --router ENDPOINT` on one of them starts it there"
        )


def read_hosts(path: Path, scenario: Scenario | None = None) -> HostsTable:
    """Read the table of hosts for the robots of a scenario, and for newcomers that its orders add; without
    one, for any robots. Raises HostsError with every problem, in the order of the file.
    """
    document = read_document(path, HostsError)
    if scenario is None:
        return parse_hosts(document, None, str(path))
    return parse_hosts(document, scenario.ids, str(path), [spec.id for spec in scenario.newcomers])


def parse_hosts(
    document: Document, robots: Sequence[int] | None, source: str = "hosts", newcomers: Sequence[int] = ()
) -> HostsTable:
    """`read_hosts`, from a parsed TOML document."""
    table, findings = read_table(document, HostsTable)
    malformed = {steps for steps, _ in findings}
    findings += [
        (steps, text)
        for steps, text in _checked(table, malformed, robots, newcomers)
        if not any(steps[:length] in malformed for length in range(len(steps) + 1))
    ]
    if not findings:
        return table
    findings.sort(key=file_order(HostsTable))
    raise HostsError(source, [Problem(written(steps), text) for steps, text in findings])


def _checked(
    table: HostsTable, malformed: Collection[Steps], robots: Sequence[int] | None, newcomers: Sequence[int]
) -> Iterator[Mistake]:
    names: dict[str, int] = {}
    endpoints: dict[tuple[str, int], int] = {}
    homes: dict[int, int] = {}
    for n, host in enumerate(table.hosts):
        yield from _host(host, n, names, endpoints)
        for m, robot in enumerate(host.robots):
            if robots is not None and robot not in (*robots, *newcomers):
                yield ("hosts", n, "robots", m), f"the scenario has no robot {robot}"
            elif homes.setdefault(robot, n) != n:
                yield ("hosts", n, "robots", m), f"robot {robot} is on hosts[{homes[robot]}] already"
    missing = [robot for robot in robots or () if robot not in homes]
    hidden = any(len(steps) < 3 or steps[2] == "robots" for steps in malformed if steps[0] == "hosts")
    if missing and not hidden:
        plural = "" if len(missing) == 1 else "s"
        yield ("hosts",), f"robot{plural} {', '.join(map(str, missing))} of the scenario must be on a host"
    if table.world and table.world not in names:
        yield ("world",), f"there is no host {table.world!r}; there are {', '.join(names)}"


def _host(
    host: Host, n: int, names: dict[str, int], endpoints: dict[tuple[str, int], int]
) -> Iterator[Mistake]:
    if not _NAME.fullmatch(host.name):
        yield ("hosts", n, "name"), "must be of letters, digits and '-', and not begin with '-'"
    elif names.setdefault(host.name, n) != n:
        yield ("hosts", n, "name"), f"is the name of hosts[{names[host.name]}] already"
    for key, where in (("address", host.address), ("listen", host.listen)):
        try:
            Endpoint.at("tcp", where or "localhost", DEFAULT_PORT)
        except UsageError:
            yield ("hosts", n, key), "must be a name or an address, without protocol, port or path"
    if not host.address:
        yield ("hosts", n, "address"), "must not be empty"
    elif host.port and endpoints.setdefault((host.address, host.port), n) != n:
        other, at = endpoints[host.address, host.port], f"{host.address}, port {host.port}"
        yield ("hosts", n, "port"), f"hosts[{other}] has its router at {at} already"
    if host.ssh.startswith("-"):
        yield ("hosts", n, "ssh"), "must be a destination such as user@host; options go into `options`"
    if not host.command:
        yield ("hosts", n, "command"), "must not be empty"


def roster_of(run: str, table: HostsTable) -> KeyRoster:
    """The roster of a run with a router, and a router key, for each host."""
    robots = sorted(robot for host in table.hosts for robot in host.robots)
    return KeyRoster(run, tuple(robots), _homes(table), table.world_host.name)


def check_fit(roster: KeyRoster, table: HostsTable) -> None:
    """Raise CertificateError unless the keys are for these hosts, each with these robots."""
    wanted, world = _homes(table), table.world_host.name
    if differing := [
        name
        for name in {**wanted, **roster.homes}
        if name not in wanted
        or name not in roster.homes
        or set(wanted[name].robots) != set(roster.homes[name].robots)
        or not set(wanted[name].addresses) <= set(roster.homes[name].addresses)
    ]:
        what = f"host {', '.join(differing)}"
    elif world != roster.world:
        what = f"the world on {world}"
    else:
        return
    raise CertificateError(
        f"the keys of the run {roster.run} do not fit {what} of the table of hosts; "
        f"make new keys: `disknav setup keys DIR --scenario S --hosts TABLE`"
    )


def exposed(table: HostsTable) -> list[str]:
    """Names of the hosts whose router can be reached from other machines."""
    return [
        host.name
        for host in table.hosts
        if not all(map(is_loopback, (host.address, host.listen or host.address)))
    ]


def _homes(table: HostsTable) -> dict[str, Home]:
    return {host.name: Home((host.address,), host.robots) for host in table.hosts}
