"""Who connects to whom: everybody to one router, or everybody to everybody."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from deploy.processes.hosts.topology import MultiHost
from deploy.security.membership import Membership
from deploy.security.roster import MONITOR, WORLD, robot_role
from protocol.bus.connection import Connection
from protocol.endpoint import Endpoint


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
