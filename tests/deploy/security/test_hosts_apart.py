"""Hosts with a router each; an attacker with all keys of one of them publishes in the name of the others."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path

import pytest

from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.security.membership import KeyRing
from deploy.security.roster import Home, KeyRoster
from protocol.bus.bus import Presence, Query, Sample
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import CertificateError, UsageError
from protocol.keys import ROBOT_STREAMS, STREAMS, everything, parse, robot_key, world_key
from tests.deploy.processes.ports import free_ports
from tests.until import until

pytestmark = [pytest.mark.process, pytest.mark.timeout(90)]

RUN, HERE = "apart", "127.0.0.1"
HOMES = {"a": Home((HERE,), (1,)), "b": Home((HERE,), (2,)), "c": Home((HERE,), (3, 4))}
ROSTER = KeyRoster(RUN, (1, 2, 3, 4), HOMES, "a")
STATES, ALL = f"disknav/{RUN}/robot/*/state", everything(RUN)
OWN, STATE = {"robot/3", "robot/4"}, robot_key(RUN, 3, "state")


def every_key() -> Iterator[str]:
    """Of each stream: one of each robot, or the world's."""
    for name in STREAMS:
        robots = ROSTER.robots if name in ROBOT_STREAMS else ()
        yield from [robot_key(RUN, robot, name) for robot in robots] or [world_key(RUN, name)]


def owner(key: str) -> str:
    """`robot/3` or `world`, of any key of the run."""
    first, _, rest = key.removeprefix(f"disknav/{RUN}/").partition("/")
    return f"{first}/{rest.partition('/')[0]}" if first == "robot" else first


def publish(bus: ZenohBus, key: str, payload: bytes) -> None:
    bus.publisher(STREAMS[parse(key).stream], key)(payload)


class Field:
    """Routers of a and b; the world and a spy on a, robot 2 on b; and a rogue with all that c has."""

    def __init__(self, stack: ExitStack, keys: Path) -> None:
        self._stack, self._keys = stack, keys
        self.endpoints = {host: f"tls/{HERE}:{port}" for host, port in zip(HOMES, free_ports(3), strict=True)}
        supervisor = stack.enter_context(Supervisor())
        for host, before in (("a", ()), ("b", ("a",))):
            supervisor.start([table.router(self._router(host, before), host=host)])
            supervisor.report(table.router_role(host), 20.0)
        self.world, self.spy = self.client("world", "a"), self.client("monitor", "a")
        self.honest = self.client("robot-2", "b")
        self.honest.subscribe(robot_key(RUN, 2, "tick"), STATES)
        self.spy.subscribe(ALL)
        self.spy.watch(ALL)
        self.rogue = self._open(replace(self._router("c", ("a", "b")), access=None))
        self.rogue.await_routers(10.0)

        def arrives(bus: ZenohBus) -> bool:
            publish(self.rogue, STATE, b"ready")
            return isinstance(bus.receive(0.05), Sample)

        for bus in (self.spy, self.honest):  # routers tell each other of subscriptions in their own time
            until(lambda bus=bus: arrives(bus), what="nothing gets through")

    def client(self, role: str, host: str) -> ZenohBus:
        return self._open(KeyRing(self._keys).client(role, (self.endpoints[host],), timeout=5.0))

    def _router(self, host: str, before: tuple[str, ...]) -> Connection:
        others = [self.endpoints[each] for each in before]
        return KeyRing(self._keys).router((self.endpoints[host],), others, host)

    def _open(self, connection: Connection) -> ZenohBus:
        return self._stack.enter_context(closing(ZenohBus(connection)))


@pytest.fixture
def field(keys: Path) -> Iterator[Field]:
    with ExitStack() as stack:
        yield Field(stack, keys)


def attack(rogue: ZenohBus) -> None:
    """Claim to be every role, offer to answer for the world, overhear all, and write under every key."""
    rogue.subscribe(ALL)
    rogue.watch(ALL)
    rogue.serve(f"disknav/{RUN}/**")
    for each in ("world", *(f"robot/{robot}" for robot in ROSTER.robots)):
        rogue.announce(f"disknav/{RUN}/{each}/alive/1")
    for key in every_key():
        publish(rogue, key, b"rogue")


def heard(bus: ZenohBus, last: bytes) -> tuple[set[str], set[str]]:
    """Owners of the keys written under, and of tokens seen, up to the sample with payload `last`."""
    written, present = set(), set()
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        event = bus.receive(0.05)
        if isinstance(event, Sample) and event.payload == last:
            return written, present
        if isinstance(event, Sample) and event.payload == b"rogue":
            written.add(owner(event.key))
        elif isinstance(event, Presence) and event.alive:
            present.add(owner(event.key))
    raise AssertionError(f"{last!r} never arrived")


def test_with_everything_of_a_host_one_speaks_for_its_robots_only(field: Field) -> None:
    attack(field.rogue)
    for mine in ("robot-3", "robot-4"):  # its robots' keys, at the routers of others
        attack(field.client(mine, "a"))
    publish(field.rogue, STATE, b"its own")
    assert heard(field.spy, b"its own") == (OWN, OWN)
    assert heard(field.honest, b"its own") == (OWN, set())  # nor as the world to others' robots
    publish(field.world, robot_key(RUN, 2, "tick"), b"for 2 alone")
    publish(field.honest, robot_key(RUN, 2, "command"), b"for the world")
    heard(field.honest, b"for 2 alone")
    heard(field.spy, b"for the world")
    overheard = iter(lambda: field.rogue.receive(0.2), None)
    assert not any(isinstance(event, Sample | Query) for event in overheard)


def test_a_host_needs_its_own_keys_only(keys: Path, tmp_path: Path) -> None:
    given = tmp_path / "keys"
    given.mkdir(mode=0o700)
    for name in ("ca.pem", "roster.json", "router-c.pem", "router-c.key"):
        (given / name).write_bytes((keys / name).read_bytes())
        (given / name).chmod(0o600)
    found = KeyRing(given).router()
    assert found.credentials == KeyRing(given).router(host="c").credentials
    with pytest.raises(CertificateError, match="no certificate for router-a"):
        KeyRing(given).router(host="a")
    with pytest.raises(UsageError, match="name the host, one of a, b, c"):
        KeyRing(keys).router()
