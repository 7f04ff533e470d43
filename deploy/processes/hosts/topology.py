"""Who connects to whom on several hosts: everybody to the router beside it, and routers to each other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from deploy.processes import table
from deploy.processes.hosts.spawners import HostSpawners
from deploy.processes.hosts.table import Host, HostsTable
from deploy.security.membership import Membership
from deploy.security.roster import MONITOR, WORLD, robot_role
from protocol.bus.connection import Connection, Credentials
from protocol.endpoint import Endpoint


def places(hosts: HostsTable) -> dict[str, str]:
    """Which host each process of a fleet runs on; what is not named runs where the launcher does."""
    robots = {table.robot_name(robot): host.name for host in hosts.hosts for robot in host.robots}
    routers = {table.router_name(host.name): host.name for host in hosts.hosts}
    return {**routers, "world": hosts.world_host.name, **robots}


@dataclass(frozen=True)
class MultiHost:
    """A connection for everybody; those of processes on other hosts come with copies of their keys."""

    hosts: HostsTable
    membership: Membership
    spawners: HostSpawners

    def router(self, host: Host) -> Connection:
        """The router of a host: linked with those of all hosts before it in the table."""
        before = self.hosts.hosts[: self.hosts.hosts.index(host)]
        listen = Endpoint.at(self.membership.protocol, host.listen or host.address, host.port)
        connection = self.membership.router(
            (listen,), [self._router_of(other) for other in before], host.name
        )
        return self._moved(connection, host)

    def world(self) -> Connection:
        """The world's connection."""
        host = self.hosts.world_host
        return self._moved(self.membership.client(WORLD, (self._router_of(host),)), host)

    def robot(self, robot: int) -> Connection:
        """A robot's connection; raises UsageError for one that is on no host of the table."""
        host = self.hosts.host_of(robot)
        return self._moved(self.membership.client(robot_role(robot), (self._router_of(host),)), host)

    def observer(self) -> Connection:
        """Connection of somebody here who only watches, to the world's router."""
        return self.membership.client(MONITOR, (self._router_of(self.hosts.world_host),))

    def viewer(self) -> Connection:
        """Connection of who watches, and gives orders if the operator's key is there."""
        return self.membership.client(self.membership.viewer, (self._router_of(self.hosts.world_host),))

    def _router_of(self, host: Host) -> Endpoint:
        return Endpoint.at(self.membership.protocol, host.address, host.port)

    def _moved(self, connection: Connection, host: Host) -> Connection:
        """The same for a process on `host`, which gets the files that this one role needs, and no more."""
        credentials, folder = connection.credentials, self.spawners.folder(host.name)
        if credentials is None or folder is None:
            return connection
        paths = (credentials.authority, credentials.certificate, credentials.key)
        for path in paths:
            self.spawners.store(host.name, Path(path))
        return replace(
            connection, credentials=Credentials(*(f"{folder}/{Path(path).name}" for path in paths))
        )
