"""Assembling a fleet: which processes there are, in which order they start, and which connect to which."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from deploy.processes import table
from deploy.processes.hosts.spawners import HostSpawners
from deploy.processes.hosts.table import Host, HostsTable, check_fit
from deploy.processes.router import reserved
from deploy.processes.spawn import Process, Spawner, core_of
from deploy.processes.supervisor import Supervisor
from deploy.run.options import RunOptions
from deploy.security.membership import KeyRing
from deploy.security.roster import MONITOR, WORLD, robot_role
from protocol.bus.connection import Connection, Credentials
from protocol.bus.zenoh import ZenohBus
from protocol.endpoint import Endpoint
from protocol.errors import DisknavError
from protocol.process.log import LOG
from protocol.scenario.model import Scenario
from world.process import look_for_others
from world.shell.admission import AWAY
from world.shell.checkpoint import Checkpoint


def places(hosts: HostsTable) -> dict[str, str]:
    """Which host each process of a fleet runs on; what is not named runs where the launcher does."""
    robots = {table.robot_name(robot): host.name for host in hosts.hosts for robot in host.robots}
    routers = {table.router_name(host.name): host.name for host in hosts.hosts}
    return {**routers, "world": hosts.world_host.name, **robots}


class Routed:
    """All are clients of the router at `endpoint`, each with what proves its role."""

    def __init__(self, endpoint: Endpoint, membership: KeyRing) -> None:
        self.membership, self.endpoint = membership, endpoint

    def world(self) -> Connection:
        """The world's connection."""
        return self._client(WORLD, self.endpoint)

    def robot(self, robot: int) -> Connection:
        """A robot's connection."""
        return self._client(robot_role(robot), self.endpoint)

    def observer(self) -> Connection:
        """Connection of what only watches."""
        return self._client(MONITOR, self.endpoint)

    def viewer(self) -> Connection:
        """Connection of what watches, and gives orders if the operator's key is there."""
        return self._client(self.membership.viewer, self.endpoint)

    def _client(self, role: str, endpoint: Endpoint) -> Connection:
        return self.membership.client(role, (endpoint,))


class MultiHost(Routed):
    """All are clients of the router of their host; those on other hosts come with copies of their keys."""

    def __init__(self, hosts: HostsTable, membership: KeyRing, spawners: HostSpawners) -> None:
        self.hosts, self.spawners = hosts, spawners
        self.membership = membership
        super().__init__(self._router_of(hosts.world_host), membership)

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
        return self._moved(super().world(), self.hosts.world_host)

    def robot(self, robot: int) -> Connection:
        """A robot's connection; raises UsageError for one that is on no host of the table."""
        host = self.hosts.host_of(robot)
        return self._moved(self._client(robot_role(robot), self._router_of(host)), host)

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
class Mesh:
    """All are peers with a link of their own to each other, over Unix sockets in `folder`.

    Sockets are files named after the listening process, so no two fleets and no other program can take one.
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
        """Connection of a monitor: to all processes, and none connects to it."""
        return Connection("peer", connect=self._endpoints(["world", *map(str, self.robots)]))

    viewer = observer

    def _endpoints(self, names: Iterable[str]) -> tuple[Endpoint, ...]:
        return tuple(self._endpoint(name) for name in names)

    def _endpoint(self, name: str) -> Endpoint:
        return Endpoint(f"unixsock-stream/{self.folder / name}")


Topology = Routed | Mesh


_START = 30.0  # s for a process to say that it is ready
_SOON = timedelta(days=1)
_WHEN = "%Y-%m-%d %H:%M UTC"


class Assembly:
    """Starts what a fleet consists of, from the router to the robots.

    Args:
        scenario: k already a number.
        options: transport, clock, names.
        record: file to record to.
        stack: whatever has to be undone at the end is put there, also if something does not start.

    Attributes:
        supervisor: of all processes.
        topology: endpoints and links.
        result: file from which the recorder takes the complete result, if the run is recorded.

    Raises:
        ProcessError, BusError: a process did not start, or an endpoint is taken.
        RunTakenError: at the router that is there already a world of this run is, too.
    """

    def __init__(
        self,
        scenario: Scenario,
        options: RunOptions,
        record: Path | None,
        stack: ExitStack,
    ) -> None:
        self._scenario, self._options = scenario, options
        self._hosts = self._host_spawners()
        # Before the supervisor, to outlast every process.
        self._folder = Path(stack.enter_context(TemporaryDirectory(prefix="disknav-")))
        spawner = self._hosts or Spawner(run=options.run, logs=options.log)
        self.supervisor = stack.enter_context(Supervisor(spawner))
        self._record = record
        self.result = None if record is None else self._folder / "result.json"
        self._ends: datetime | None = None
        self.topology = self._begin(stack)
        self._start_world(self._checkpoint())

    @property
    def expired(self) -> str:
        """What to add to the reason why a fleet was lost, if its certificates have ended."""
        if self._ends is None or datetime.now(UTC) < self._ends:
            return ""
        return f"; the certificates in {self._options.secure} ended at {self._ends:{_WHEN}}: make new ones"

    def robots(self) -> list[Process]:
        """The rows of all robots, which are not started yet."""
        ids = self._scenario.ids
        together = len(ids) if self._options.lockstep and self._hosts is None else 0
        return [self._robot(robot, core_of(turn, together)) for turn, robot in enumerate(ids)]

    def _robot(self, robot: int, core: int | None = None) -> Process:
        options, connection = self._options, self.topology.robot(robot)
        return table.robot(connection, options.run, robot, options.restarts, core)

    def start_newcomer(self, robot: int) -> None:
        """The process of a robot that was added, on this host; a person must if this cannot."""
        name = table.robot_name(robot)
        if name in self.supervisor.names:
            self.supervisor.restart(name)
            return
        if isinstance(self.topology, Mesh):
            self.topology = self.topology.joined(robot)
        try:
            self.supervisor.start([self._robot(robot)])
        except DisknavError as error:
            LOG.error(f"the process of robot {robot} is to be started by hand: {error}")

    def _host_spawners(self) -> HostSpawners | None:
        hosts = self._options.hosts
        if hosts is None:
            return None
        if (roster := KeyRing(self._options.secure).roster()) is not None:
            check_fit(roster, hosts)
        return HostSpawners(hosts, places(hosts), self._options.run, self._options.log)

    def _begin(self, stack: ExitStack) -> Topology:
        options = self._options
        if options.transport == "mesh":
            return Mesh(self._folder, self._scenario.ids)
        membership = KeyRing(options.secure)
        membership.run(options.run)  # or the router would turn all away
        self._ends = membership.end()
        if self._ends is not None and self._ends - datetime.now(UTC) < _SOON:
            LOG.warning(
                f"the certificates in {options.secure} end at {self._ends:{_WHEN}}, and links with them"
            )
        if options.router is not None:
            topology = Routed(membership.endpoint(options.router), membership)
            with closing(ZenohBus(topology.observer())) as bus:
                look_for_others(bus, options.run)
            return topology
        if options.hosts is not None and self._hosts is not None:
            return self._link(MultiHost(options.hosts, membership, self._hosts))
        router = table.router(
            membership.router(() if options.listen is None else (options.listen,)),
            options.restarts,
        )
        self.supervisor.start([router])
        endpoint = Endpoint(self.supervisor.report(table.ROUTER, _START))
        connection, *others = router.arguments  # its successor has to be found where it was
        again = (replace(connection, listen=(endpoint,)), *others)
        self.supervisor.amend(replace(router, arguments=again))
        if options.restarts:
            with suppress(OSError):  # of a name that is none of this host, or taken: then it is as it was
                stack.enter_context(reserved(endpoint))
        return Routed(endpoint, membership)

    def _link(self, multi_host: MultiHost) -> MultiHost:
        """A router on every host, each linked with all before it: no message can be lost on a detour."""
        multi_host.spawners.greet()
        for host in multi_host.hosts.hosts:
            connection, vital = multi_host.router(host), host is multi_host.hosts.world_host
            restarts = self._options.restarts
            self.supervisor.start([table.router(connection, restarts, host.name, vital=vital)])
            self.supervisor.report(table.router_name(host.name), _START)
        return multi_host

    def _checkpoint(self) -> Path | None:
        """Where the world is to keep its checkpoint, if it is to be started again: made here, so that a world
        that finds none does not begin anew what another one began."""
        if not self._options.restarts:
            return None
        checkpoint = self._folder / "checkpoint"
        Checkpoint.create(checkpoint)
        hosts, spawners = self._options.hosts, self._hosts
        folder = None if hosts is None or spawners is None else spawners.folder(hosts.world_host.name)
        if hosts is None or spawners is None or folder is None:
            return checkpoint
        spawners.store(hosts.world_host.name, checkpoint)
        return Path(folder) / checkpoint.name

    def _start_world(self, checkpoint: Path | None) -> None:
        """The world, and before anything can happen the recorder."""
        run, topology = self._options.run, self.topology
        options = self._options
        world = table.world(
            topology.world(),
            run,
            self._scenario,
            options.lockstep,
            speed=options.speed,
            restarts=options.restarts,
            checkpoint=checkpoint,
        )
        self.supervisor.start([world])
        if self._record is not None and self.result is not None:
            away = AWAY if options.restarts else 0.0
            row = partial(
                table.recorder,
                topology.observer(),
                run,
                self._record,
                self.result,
                options.rotation,
                away,
                options.restarts,
            )
            self.supervisor.start([row()])
            self.supervisor.report(table.RECORDER, _START)
            self.supervisor.amend(row(again=True))
