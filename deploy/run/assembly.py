"""Assembly of a fleet: its processes, the order of their start, and their connections."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from tempfile import TemporaryDirectory

from deploy.processes import table
from deploy.processes.hosts.ssh import SshSpawner
from deploy.processes.hosts.table import Host, HostsTable, check_fit
from deploy.processes.router import reserved
from deploy.processes.spawn import Process, Spawner, core_of
from deploy.processes.supervisor import Supervisor
from deploy.run.options import RunOptions
from deploy.security.membership import KeyRing
from deploy.security.roster import MONITOR, ROUTER, WORLD, robot_role, router_role
from protocol.bus.connection import Connection, Credentials, Endpoint
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError, DisknavError, StartError
from protocol.process.log import LOG
from protocol.scenario.model import Scenario
from world.process import look_for_others
from world.shell.admission import GRACE
from world.shell.checkpoint import Checkpoint
from world.shell.failure_detector import RETURNS


def places(hosts: HostsTable | None) -> dict[str, str]:
    """Name of a process -> name of its host; all others run on the launcher's host."""
    if hosts is None:
        return {}
    robots = {robot_role(robot): host.name for host in hosts.hosts for robot in host.robots}
    routers = {router_role(host.name): host.name for host in hosts.hosts}
    return {**routers, WORLD: hosts.world_host.name, **robots}


class Routed:
    """Connections to the router at `endpoint`, each with the credentials of its role."""

    def __init__(self, endpoint: Endpoint, membership: KeyRing) -> None:
        self.membership, self.endpoint = membership, endpoint

    def connection(self, role: str) -> Connection:
        """Connection of a process, or of a monitor or operator on this host."""
        return self.membership.client(role, (self.endpoint,))


class MultiHost(Routed):
    """Connections to the router of each process's host; keys are copied to other hosts."""

    def __init__(self, hosts: HostsTable, membership: KeyRing, spawners: Mapping[str, SshSpawner]) -> None:
        self.hosts, self._spawners = hosts, spawners
        self.membership = membership
        super().__init__(self._router_of(hosts.world_host), membership)

    def router(self, host: Host) -> Connection:
        """The router of a host, linked with those of all hosts before it in the table."""
        before = self.hosts.hosts[: self.hosts.hosts.index(host)]
        listen = Endpoint.at(self.membership.protocol, host.listen or host.address, host.port)
        connection = self.membership.router(
            (listen,), [self._router_of(other) for other in before], host.name
        )
        return self._moved(connection, host)

    def connection(self, role: str) -> Connection:
        """Raises UsageError for a robot that is on no host of the table."""
        robot = table.robot_of(role)
        if robot is None and role != WORLD:
            return super().connection(role)
        host = self.hosts.world_host if robot is None else self.hosts.host_of(robot)
        return self._moved(self.membership.client(role, (self._router_of(host),)), host)

    def _router_of(self, host: Host) -> Endpoint:
        return Endpoint.at(self.membership.protocol, host.address, host.port)

    def _moved(self, connection: Connection, host: Host) -> Connection:
        """The same connection for a process on `host`, to which the files of this role alone are copied."""
        credentials, spawner = connection.credentials, self._spawners.get(host.name)
        if credentials is None or spawner is None:
            return connection
        paths = (credentials.authority, credentials.certificate, credentials.key)
        return replace(connection, credentials=Credentials(*(spawner.store(Path(path)) for path in paths)))


@dataclass(frozen=True)
class Mesh:
    """Connections of peers, each linked to all others over Unix sockets in `folder`.

    Sockets are files named after the listening process, so other fleets and programs cannot occupy them. Each
    process listens, and connects to those before it: the world, a recorder, then robots in their order. So
    the recorder misses nothing of a robot, whenever that starts.
    """

    folder: Path
    roles: tuple[str, ...]  # of all processes that listen

    def connection(self, role: str) -> Connection:
        """Connection of a process; or of a monitor to all processes, which does not listen."""
        if role not in self.roles:
            return Connection("peer", connect=tuple(map(self._endpoint, self.roles)))
        before = self.roles[: self.roles.index(role)]
        return Connection("peer", connect=tuple(map(self._endpoint, before)), listen=(self._endpoint(role),))

    def joined(self, role: str) -> Mesh:
        """The mesh with another process at its end."""
        return self if role in self.roles else replace(self, roles=(*self.roles, role))

    def _endpoint(self, role: str) -> Endpoint:
        return Endpoint(f"unixsock-stream/{self.folder / role}")


Topology = Routed | Mesh


_CLOSING = 30.0  # s for the recorder, which has low priority, to close its file
_GREETING = 30.0  # s for all hosts to answer
_START = 30.0  # s for a process to report that it is ready
_SOON = timedelta(days=1)
_WHEN = "%Y-%m-%d %H:%M UTC"


class Assembly:
    """Starts the processes of a fleet, from the router to the world; and robots on request.

    `stack` receives all clean-up callbacks, also if a start fails.

    Raises:
        ProcessError, BusError: a process did not start, or an endpoint is taken.
        RunTakenError: another world of this run uses the given router or endpoint.
    """

    def __init__(
        self, scenario: Scenario, options: RunOptions, record: Path | None, stack: ExitStack
    ) -> None:
        self._scenario, self._options = scenario, options
        hosts = options.hosts
        if hosts is not None and (roster := KeyRing(options.secure).roster()) is not None:
            check_fit(roster, hosts)
        # Entered before the supervisor, to outlast every process.
        self._folder = Path(
            stack.enter_context(TemporaryDirectory(prefix="disknav-", ignore_cleanup_errors=True))
        )
        here, there = Spawner(run=options.run, logs=options.log), hosts.hosts if hosts is not None else ()
        self._there = {host.name: SshSpawner(host, options.run, options.log) for host in there if host.ssh}
        self.supervisor = stack.enter_context(Supervisor(here, self._there, places(hosts)))
        self._record = record
        # The recorder reads the complete result from this file, if the run is recorded.
        self.result = None if record is None else self._folder / "result.json"
        self._ends: datetime | None = None
        self.topology = self._begin(stack)
        self._start_world(self._checkpoint())

    @property
    def expired(self) -> str:
        """Text to append to the reason of a lost fleet if its certificates have expired."""
        if self._ends is None or datetime.now(UTC) < self._ends:
            return ""
        return f"; the certificates in {self._options.secure} expired at {self._ends:{_WHEN}}: make new ones"

    def robots(self) -> list[Process]:
        """Rows of all robots, not yet started."""
        ids = self._scenario.ids
        together = len(ids) if self._options.lockstep and self._options.hosts is None else 0
        return [self._robot(robot, core_of(turn, together)) for turn, robot in enumerate(ids)]

    def _robot(self, robot: int, core: int | None = None) -> Process:
        options, connection = self._options, self.topology.connection(robot_role(robot))
        return table.robot(connection, options.run, robot, options.restarts, core)

    def start_newcomer(self, robot: int) -> None:
        """Start the process of an added robot; if that fails, log that it must be started by hand."""
        name = robot_role(robot)
        if name in self.supervisor.names:
            self.supervisor.restart(name)
            return
        if isinstance(self.topology, Mesh):
            self.topology = self.topology.joined(name)
        try:
            self.supervisor.start([self._robot(robot)])
        except DisknavError as error:
            LOG.error(f"start the process of robot {robot} by hand: {error}")

    def _begin(self, stack: ExitStack) -> Topology:
        options = self._options
        if options.transport == "mesh":
            recorder = () if self._record is None else (table.RECORDER,)
            return Mesh(self._folder, (WORLD, *recorder, *map(robot_role, self._scenario.ids)))
        membership = KeyRing(options.secure)
        membership.run(options.run)  # refuses keys of another run
        self._ends = membership.end()
        if self._ends is not None and self._ends - datetime.now(UTC) < _SOON:
            LOG.warning(
                f"the certificates in {options.secure}, and all links, expire at {self._ends:{_WHEN}}"
            )
        if options.router is not None:
            topology = Routed(membership.endpoint(options.router), membership)
            with closing(ZenohBus(topology.connection(MONITOR))) as bus:
                look_for_others(bus, options.run)
            return topology
        if options.hosts is not None:
            return self._link(MultiHost(options.hosts, membership, self._there))
        router = table.router(
            membership.router(() if options.listen is None else (options.listen,)), options.restarts
        )
        self.supervisor.start([router])
        try:
            endpoint = Endpoint(self.supervisor.report(ROUTER, _START))
        except StartError:
            if options.listen is not None:  # this very run may have the endpoint
                there = membership.client(MONITOR, (options.listen,), timeout=5.0)
                with suppress(BusError), closing(ZenohBus(there)) as bus:
                    look_for_others(bus, options.run)
            raise
        connection, *others = router.arguments  # a restarted router keeps the endpoint
        again = (replace(connection, listen=(endpoint,)), *others)
        self.supervisor.amend(replace(router, arguments=again))
        if options.restarts:
            with suppress(OSError):  # not an address of this host, or taken: the port stays unreserved
                stack.enter_context(reserved(endpoint))
        return Routed(endpoint, membership)

    def _link(self, multi_host: MultiHost) -> MultiHost:
        """Start a router on every host, each linked with all before it, so that no message needs a detour."""
        deadline = time.monotonic() + _GREETING
        for spawner in self._there.values():
            spawner.greet(deadline - time.monotonic())
        for host in multi_host.hosts.hosts:
            connection, vital = multi_host.router(host), host is multi_host.hosts.world_host
            restarts = self._options.restarts
            self.supervisor.start([table.router(connection, restarts, host.name, vital=vital)])
            self.supervisor.report(router_role(host.name), _START)
        return multi_host

    def _checkpoint(self) -> Path | None:
        """Create an empty checkpoint if the world may be restarted.

        It is created here so that a restarted world that finds no checkpoint cannot start the run again.
        """
        if not self._options.restarts:
            return None
        checkpoint = self._folder / "checkpoint"
        Checkpoint.create(checkpoint)
        spawner = self._there.get(places(self._options.hosts).get(WORLD, ""))
        return checkpoint if spawner is None else Path(spawner.store(checkpoint))

    def _start_world(self, checkpoint: Path | None) -> None:
        """Start the world, and the recorder before the first tick."""
        options, topology = self._options, self.topology
        world = table.world(
            topology.connection(WORLD),
            options.run,
            self._scenario,
            options.lockstep,
            speed=options.speed,
            restarts=options.restarts,
            checkpoint=checkpoint,
            returns=0 if options.hosts is None else RETURNS,
        )
        self.supervisor.start([world])
        if self._record is not None and self.result is not None:
            grace = GRACE if options.restarts else 0.0
            role = table.RECORDER if isinstance(topology, Mesh) else MONITOR
            arguments = (
                topology.connection(role),
                options.run,
                self._record,
                self.result,
                options.rotation,
                grace,
                False,
            )
            row = Process(
                table.RECORDER,
                "deploy.telemetry.recording.recorder:main",
                arguments,
                restarts=options.restarts,
                reports=True,
                patience=_CLOSING,
            )
            self.supervisor.start([row])
            self.supervisor.report(table.RECORDER, _START)
            self.supervisor.amend(replace(row, arguments=(*arguments[:-1], True)))  # replaces a failed one
