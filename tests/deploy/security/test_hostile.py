"""Neighbours that lie well, hold connections open, or whose time is up: what a secured run makes of them."""

import json
import socket
import time
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
from deploy.run.result import unjudged
from deploy.security.keystore import create
from deploy.security.membership import KeyRing
from deploy.security.roster import KeyRoster
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.codec import encode
from protocol.errors import BusError
from protocol.keys import STREAMS, robot_key, world_key
from protocol.messages import Clock, Command, Health, Member, Message, Result, Standing, State, Tick, Truth
from protocol.messages import Roster as Presences
from protocol.scenario.model import Scenario

pytestmark = [pytest.mark.process, pytest.mark.timeout(90)]

RUN = "guarded"
SCENARIO = load("swap-4", ["control.speed=0.05"])
AWAY = (5.0, 5.0)
Lie = tuple[str, str, bytes]  # stream, key, payload


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("hostile") / "keys"
    create(directory, KeyRoster(RUN, SCENARIO.ids))
    return directory


_LIFE = 10.0  # s of a certificate: more than a loaded machine needs to start the fleet


def lies(scenario: Scenario, tick: int, own: int | None) -> list[Lie]:
    """Well-formed messages for each receiver, in the name of every role but the sender's."""
    ids = scenario.ids
    gone = Presences(1000 + tick, tuple(Member(i, 9, "gone", 0.03) for i in ids))
    report = {**unjudged(scenario, None, 1.0), "verdict": "arrived"}
    world: dict[str, Message] = {
        "result": Result(json.dumps(report)),
        "clock": Clock(tick, 0.05 * tick, (), tuple(Standing(i, 1, AWAY) for i in ids), "collision"),
        "truth": Truth(tick, ids, (AWAY,) * len(ids), -1.0, 1.0),
    }
    found = [(stream, world_key(RUN, stream), encode(message)) for stream, message in world.items()]
    for robot in ids:
        if robot == own:
            continue
        said: dict[str, Message] = {
            "tick": Tick(robot, 1, tick, (), roster=gone, halted=True),
            "state": State(robot, 1, tick, AWAY, 0.0, 0.0, 0.0, (0.0, 0.0)),
            "command": Command(robot, 1, tick, (0.05, 0.05)),
            "health": Health(robot, 1, tick, 0.0, 0, 0, {}, (), ()),
        }
        found += [
            (stream, robot_key(RUN, robot, stream), encode(message)) for stream, message in said.items()
        ]
    return found


class Liar:
    """A process with the certificate of a role that publishes in the name of all others."""

    def __init__(self, connection: Connection, own: int | None) -> None:
        self.bus, self._own = ZenohBus(connection), own
        self.answers: list[bytes] = []
        self.told = 0
        self._publish = {
            key: self.bus.publisher(STREAMS[stream], key) for stream, key, _ in lies(SCENARIO, 0, own)
        }
        other = next(robot for robot in SCENARIO.ids if robot != own)
        halt = msgspec.msgpack.encode({"halt": True})
        for key, request in ((world_key(RUN, "operation"), halt), (robot_key(RUN, other, "join"), b"")):
            with suppress(BusError):
                self.answers += self.bus.ask(key, request, 0.2)

    def lie(self, tick: int) -> None:
        for _, key, payload in lies(SCENARIO, tick, self._own):
            self._publish[key](payload)
            self.told += 1


def test_lies_without_the_right_to_write_change_nothing(keys: Path) -> None:
    liars: list[Liar] = []

    def lie(clock: Clock) -> None:
        if not liars and clock.tick >= 2:
            router = fleet.topology.observer().connect
            for role, own in (("robot-2", 2), ("monitor", None)):
                liars.append(Liar(KeyRing(keys).client(role, router), own))
                stack.enter_context(closing(liars[-1].bus))
        for liar in liars:
            liar.lie(clock.tick + 1)

    options = RunOptions(run=RUN, secure=keys, speed=8.0)
    with Fleet(SCENARIO, options, watch=lie) as fleet, ExitStack() as stack:
        report = fleet.execute()
    assert len(liars) == 2
    assert all(liar.told > 100 and not liar.answers for liar in liars)
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
