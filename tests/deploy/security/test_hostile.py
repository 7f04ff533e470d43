"""Neighbours that lie, hold connections open, or whose time is up: what a secured run makes of them."""

import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from pathlib import Path

import msgspec
import pytest

from deploy.library.load import load
from deploy.processes import table
from deploy.processes.supervisor import Supervisor
from deploy.run.fleet import Fleet
from deploy.run.local import LocalFleet
from deploy.run.options import RunOptions
from deploy.security.keystore import create
from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster
from protocol.bus.bus import Publish
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError
from protocol.keys import ROBOT_STREAMS, STREAMS, robot_key, world_key
from protocol.messages import Clock

pytestmark = [pytest.mark.process, pytest.mark.timeout(90)]

RUN = "guarded"
SCENARIO = load("swap-4", ["control.speed=0.05"])
ROSTER = KeyRoster(RUN, SCENARIO.ids)


_LIFE = 10.0  # s of a certificate: more than a loaded machine needs to start the fleet


def lies(bus: ZenohBus, own: int | None) -> Iterator[Publish]:
    """What writes under each key but those of robot `own`."""
    for name, stream in STREAMS.items():
        robots = [robot for robot in SCENARIO.ids if robot != own and name in ROBOT_STREAMS]
        for key in [robot_key(RUN, robot, name) for robot in robots] or [world_key(RUN, name)]:
            yield bus.publisher(stream, key)


def answers(bus: ZenohBus, own: int | None) -> list[bytes]:
    """To a request to halt all robots, and to join as another one."""
    found, other = list[bytes](), next(robot for robot in SCENARIO.ids if robot != own)
    halt = msgspec.msgpack.encode({"halt": True})
    for key, request in ((world_key(RUN, "operation"), halt), (robot_key(RUN, other, "join"), b"")):
        with suppress(BusError):
            found += bus.ask(key, request, 0.2)
    return found


def test_lies_without_the_right_to_write_change_nothing(keys: Path) -> None:
    """Whoever heard one would count it."""
    lying: list[Publish] = []
    told = 0

    def watch(clock: Clock) -> None:
        nonlocal told
        if not lying and clock.tick >= 2:
            router = fleet.topology.connection("monitor").connect
            for role, own in (("robot-2", 2), ("monitor", None)):
                bus = stack.enter_context(closing(ZenohBus(KeyRing(keys).client(role, router))))
                assert answers(bus, own) == []
                lying.extend(lies(bus, own))
        for publish in lying:
            publish(b"a lie")
            told += 1

    options = RunOptions(run=RUN, secure=keys, speed=8.0)
    with Fleet(SCENARIO, options, watch=watch) as fleet, ExitStack() as stack:
        report = fleet.execute()
    assert told > 200
    assert report["verdict"] == "arrived"
    assert report["trajectory_sha256"] == LocalFleet(SCENARIO).execute()["trajectory_sha256"]
    assert report["messages"]["rejected"] == {}
    assert fleet.rejected == {}


def test_half_open_links_keep_no_client_out(keys: Path) -> None:
    """Connections that say nothing, or begin a handshake and stop."""
    with Supervisor() as supervisor, ExitStack() as stack:
        supervisor.start([table.router(KeyRing(keys).router())])
        endpoint = supervisor.report(table.ROUTER, 20.0)
        host, _, port = endpoint.partition("/")[2].rpartition(":")
        for n in range(400):
            link = stack.enter_context(socket.create_connection((host, int(port))))
            if n % 2:
                link.send(b"\x16\x03\x01\x02\x00\x01\x00")
        ZenohBus(KeyRing(keys).client("robot-1", (endpoint,))).close()


@pytest.mark.long(12)
def test_certificates_that_expire_end_the_run_standing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    slow = load("swap-4", ["control.speed=0.002"])
    create(tmp_path / "keys", KeyRoster(RUN, slow.ids), days=_LIFE / 86400.0)
    options = RunOptions(mode="realtime", run=RUN, secure=tmp_path / "keys")
    with Fleet(slow, options) as fleet:
        began = time.monotonic()
        report = fleet.execute(lambda: time.monotonic() > began + 8.0 * _LIFE)
    assert report["verdict"] == "aborted"
    assert f"the certificates in {tmp_path / 'keys'} expired at" in report["reason"]
    assert "make new ones" in report["reason"]
    assert report["collisions"] == 0
    assert any("and all links, expire" in message for message in caplog.messages)
