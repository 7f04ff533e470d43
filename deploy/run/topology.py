"""Which process connects to which: all to one router, all to all, or each to the router of its host."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
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


@dataclass(frozen=True)
class Routed:
    """All are clients of the router at `endpoint`, each with what proves its role."""

    endpoint: Endpoint
    membership: Membership = field(default_factory=Membership)

    def world(self) -> Connection:
        """The world's connection."""
        return self.membership.client(WORLD, (self.endpoint,))

    def robot(self, robot: int) -> Connection:
        """A robot's connection."""
        return self.membership.client(robot_role(robot), (self.endpoint,))

    def observer(self) -> Connection:
        """Connection of somebody who only watches."""
        return self.membership.client(MONITOR, (self.endpoint,))

    def viewer(self) -> Connection:
        """Connection of who watches, and gives orders if the operator's key is there."""
        return self.membership.client(self.membership.viewer, (self.endpoint,))


@dataclass(frozen=True)
class Mesh:
    """All are peers with a link of their own to each other, over Unix sockets in `folder`.

    Sockets are files named after who listens, so no two fleets and no other program can take one.
    Each listens, and connects to those before it: the world, then robots in their order.
    """

    folder: Path
    robots: tuple[int, ...]

    def world(self) -> Connection:
        """The world's connection."""
        return Connection("peer", listen=(self._endpoint("world"),))

    def robot(self, robot: int) -> Connection:
        """A robot's connection."""
        before = ["world", *map(str, self.robots[: self.robots.index(robot)])]
        return Connection("peer", connect=self._endpoints(before), listen=(self._endpoint(str(robot)),))

    def joined(self, robot: int) -> Mesh:
        """The mesh with another robot, after all others."""
        return self if robot in self.robots else replace(self, robots=(*self.robots, robot))

    def observer(self) -> Connection:
        """Connection of somebody who only watches: to everybody, and nobody connects to it."""
        return Connection("peer", connect=self._endpoints(["world", *map(str, self.robots)]))

    viewer = observer

    def _endpoints(self, names: Iterable[str]) -> tuple[Endpoint, ...]:
        return tuple(self._endpoint(name) for name in names)

    def _endpoint(self, name: str) -> Endpoint:
        return Endpoint(f"unixsock-stream/{self.folder / name}")


Topology = Routed | Mesh | MultiHost
