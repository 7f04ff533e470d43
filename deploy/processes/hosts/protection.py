"""What keeps a table of hosts apart from strangers, and its hosts apart from each other: keys made for it."""

from __future__ import annotations

from ipaddress import ip_address

from deploy.processes.hosts.table import HostsTable
from deploy.security.roster import Home, Roster
from protocol.errors import CertificateError


def roster_of(run: str, table: HostsTable) -> Roster:
    """The roster of a run whose every host has a router, and a key, of its own."""
    robots = sorted(robot for host in table.hosts for robot in host.robots)
    return Roster(run, tuple(robots), _homes(table), table.world_host.name)


def check_fit(roster: Roster, table: HostsTable) -> None:
    """Check that the keys are for these hosts, with these robots behind each.

    Raises:
        CertificateError: they are not; says which host differs.
    """
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
        f"the keys of the run {roster.run} are not for {what} as the table of hosts has it; "
        f"`disknav setup keys DIR --scenario S --hosts TABLE` makes a key for each host of a table"
    )


def exposed(table: HostsTable) -> list[str]:
    """Hosts whose router others than this machine's users can reach."""
    return [
        host.name
        for host in table.hosts
        if not all(map(_is_loopback, (host.address, host.listen or host.address)))
    ]


def _homes(table: HostsTable) -> dict[str, Home]:
    return {host.name: Home((host.address,), host.robots) for host in table.hosts}


def _is_loopback(address: str) -> bool:
    try:
        return ip_address(address).is_loopback
    except ValueError:
        return address == "localhost"
