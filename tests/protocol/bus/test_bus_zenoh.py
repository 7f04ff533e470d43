"""The zenoh bus on real sessions: through a router, and between peers."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from math import inf
from pathlib import Path

import pytest

from deploy.processes.router import listening
from deploy.processes.supervisor import Supervisor
from protocol.bus.connection import Connection, configuration
from protocol.bus.drive import Stop, drive, stop_on_signal
from protocol.bus.events import Event, Presence, Request, Sample
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError, EndpointTakenError
from protocol.streams import STREAMS
from tests.deploy.processes import children

pytestmark = pytest.mark.timeout(30)

STATE, ALIVE = "disknav/t/robot/1/state", "disknav/t/robot/1/alive"
SCENARIO = "disknav/t/world/scenario"
PATIENCE = 10.0

Connect = Callable[..., ZenohBus]


@pytest.fixture
def endpoint() -> Iterator[str]:
    bus, where = listening(Connection("router"))
    with closing(bus):
        yield where


@pytest.fixture
def connect(endpoint: str) -> Iterator[Connect]:
    with ExitStack() as stack:
        connection = Connection(connect=(endpoint,))
        yield lambda **how: stack.enter_context(closing(ZenohBus(connection, **how)))


def exchange(first: ZenohBus, second: ZenohBus) -> None:
    """Everything that a fleet does, from `second` to `first`."""
    first.watch("disknav/t/robot/*/alive")
    first.subscribe(STATE, "disknav/t/robot/999/state")
    first.serve(SCENARIO)
    publish = second.publisher(STREAMS["state"], STATE)
    second.announce(ALIVE)
    assert first.receive(PATIENCE) == Presence(ALIVE, True)
    answering = threading.Thread(target=answer, args=(first, b"yes"))
    answering.start()
    assert second.ask(SCENARIO, b"may I?", PATIENCE) == b"yes"
    answering.join()
    publish(b"here")  # the answer came after the subscription: before, nobody might be known to listen
    assert first.receive(PATIENCE) == Sample(STATE, b"here")
    second.close()
    assert first.receive(PATIENCE) == Presence(ALIVE, False)


def answer(bus: ZenohBus, reply: bytes) -> None:
    request = bus.receive(PATIENCE)
    assert isinstance(request, Request)
    assert (request.key, request.payload) == (SCENARIO, b"may I?")
    request.reply(reply)


def test_clients_exchange_through_a_router(connect: Connect) -> None:
    exchange(connect(), connect())


@pytest.mark.parametrize("scheme", ["tcp", "unixsock-stream"])
def test_peers_exchange_without_anybody_in_the_middle(scheme: str, tmp_path: Path) -> None:
    with ExitStack() as stack:
        if scheme == "tcp":
            with socket.create_server(("127.0.0.1", 0)) as probe:  # beyond the ports that routers take
                where = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        else:
            where = f"unixsock-stream/{tmp_path / 'world'}"
        first = stack.enter_context(closing(ZenohBus(Connection("peer", listen=(where,)))))
        second = stack.enter_context(closing(ZenohBus(Connection("peer", connect=(where,)))))
        exchange(first, second)


def test_a_peer_announces_itself_when_all_its_links_are_up(tmp_path: Path) -> None:
    ends = [f"unixsock-stream/{tmp_path / name}" for name in ("world", "early", "late")]
    heard: list[Event | None] = []
    with ExitStack() as stack:

        def peer(connect: list[str], listen: list[str]) -> ZenohBus:
            connection = Connection("peer", connect=tuple(connect), listen=tuple(listen))
            return stack.enter_context(closing(ZenohBus(connection)))

        world = peer([], ends[:1])
        world.watch("disknav/t/**")
        early = peer(ends[:1] + ends[2:], [ends[1]])
        announcing = threading.Thread(target=early.announce, args=(ALIVE,))
        announcing.start()
        heard.append(world.receive(0.3))
        peer([], [ends[2]])
        heard.append(world.receive(PATIENCE))
        announcing.join()
    assert heard == [None, Presence(ALIVE, True)]


@pytest.mark.process
def test_a_killed_peer_can_come_back_under_its_endpoint(tmp_path: Path) -> None:
    world, robot, later = (f"unixsock-stream/{tmp_path / name}" for name in ("world", "1", "2"))
    with ExitStack() as stack:
        first = stack.enter_context(closing(ZenohBus(Connection("peer", listen=(world,)))))
        supervisor = stack.enter_context(Supervisor(children.spawner()))
        connection = Connection("peer", connect=(world,), listen=(robot,))
        supervisor.start([children.row("robot-1", children.announce, connection, ALIVE)])
        first.watch(ALIVE)
        assert first.receive(PATIENCE) == Presence(ALIVE, True)
        connection = Connection("peer", connect=(world, robot), listen=(later,))
        second = stack.enter_context(closing(ZenohBus(connection)))
        second.watch(ALIVE)
        assert second.receive(PATIENCE) == Presence(ALIVE, True)
        supervisor.restart("robot-1")
        for bus in (first, second):
            assert bus.receive(PATIENCE) == Presence(ALIVE, False)
            assert bus.receive(PATIENCE) == Presence(ALIVE, True)


def test_a_bus_does_not_hear_itself(connect: Connect) -> None:
    speaker, listener = connect(), connect()
    for bus in (speaker, listener):
        bus.subscribe("disknav/t/robot/*/state")
    publish = speaker.publisher(STREAMS["state"], STATE)
    speaker.announce(ALIVE)
    listener.watch(ALIVE)
    assert listener.receive(PATIENCE) == Presence(ALIVE, True)
    deadline, heard = time.monotonic() + PATIENCE, None
    while heard is None and time.monotonic() < deadline:  # until the speaker knows that somebody listens
        publish(b"1")
        heard = listener.receive(0.1)
    assert heard == Sample(STATE, b"1")
    assert speaker.receive(0.05) is None


def test_watching_tells_of_those_already_there(connect: Connect) -> None:
    early, late = connect(), connect()
    early.announce(ALIVE)
    late.watch("disknav/t/robot/*/alive")
    assert late.receive(PATIENCE) == Presence(ALIVE, True)


@pytest.mark.process
def test_presence_goes_with_a_killed_process(connect: Connect, endpoint: str) -> None:
    watcher = connect()
    watcher.watch(ALIVE)
    with Supervisor(children.spawner()) as supervisor:
        supervisor.start([children.row("robot-1", children.announce, Connection(connect=(endpoint,)), ALIVE)])
        assert watcher.receive(PATIENCE) == Presence(ALIVE, True)
        supervisor.kill("robot-1")
        begin = time.monotonic()
        assert watcher.receive(PATIENCE) == Presence(ALIVE, False)
        assert time.monotonic() - begin < 5.0  # half of what an unnoticed death would take


def test_asking_waits_for_whoever_will_serve(connect: Connect) -> None:
    asker, server = connect(), connect()
    replies: list[bytes] = []
    asking = threading.Thread(target=lambda: replies.append(asker.ask(SCENARIO, b"may I?", PATIENCE)))
    asking.start()
    assert server.receive(0.1) is None  # the first attempts find nobody
    server.serve(SCENARIO)
    answer(server, b"now")
    asking.join()
    assert replies == [b"now"]


@pytest.mark.parametrize("served", [False, True])
def test_an_unanswered_request_ends_in_time(connect: Connect, served: bool) -> None:
    if served:
        connect().serve(SCENARIO)  # by somebody who never looks
    begin = time.monotonic()
    with pytest.raises(BusError, match=SCENARIO):
        connect().ask(SCENARIO, b"may I?", 0.3)
    assert time.monotonic() - begin < 2.0


@pytest.mark.parametrize("timeout", [0.0, 0.05])
def test_receiving_is_bounded(connect: Connect, timeout: float) -> None:
    bus = connect()
    begin = time.monotonic()
    assert bus.receive(timeout) is None
    assert timeout <= time.monotonic() - begin < timeout + 1.0


def test_a_signal_interrupts_receiving(connect: Connect) -> None:
    bus = connect()
    terminate = threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGTERM))

    @stop_on_signal()
    def receive() -> None:
        terminate.start()
        bus.receive(inf)

    with pytest.raises(Stop) as stop:
        receive()
    assert stop.value.signal == signal.SIGTERM


def test_zenohs_threads_leave_signals_alone(connect: Connect) -> None:
    connect()
    blocked = []
    for path in Path("/proc/self/task").iterdir():
        with suppress(OSError):  # ended since
            if path.name != str(os.getpid()) and (path / "comm").read_text().startswith(("net-", "rx-")):
                blocked.append((path / "status").read_text().partition("SigBlk:\t")[2][:16])
    assert blocked
    assert all(int(mask, 16) >> (signal.SIGTERM - 1) & 1 for mask in blocked)


def test_a_flood_is_shed_and_counted(connect: Connect) -> None:
    speaker, listener = connect(), connect(capacity=8)
    listener.subscribe(STATE)
    listener.watch(ALIVE)
    publish = speaker.publisher(STREAMS["state"], STATE)
    speaker.announce(ALIVE)
    assert listener.receive(PATIENCE) == Presence(ALIVE, True)
    for number in range(20):
        publish(bytes([number]))
    speaker.close()
    deadline = time.monotonic() + PATIENCE
    while listener._queue.qsize() < 21 and time.monotonic() < deadline:  # and that its token is gone
        time.sleep(0.005)
    heard: list[Event] = []
    while len(heard) + listener.dropped < 21:
        event = listener.receive(PATIENCE)
        assert event is not None
        heard.append(event)
    assert len(heard) + listener.dropped == 21
    assert listener.dropped > 0


def test_an_unreachable_router_is_named() -> None:
    nowhere = "tcp/127.0.0.1:9"
    begin = time.monotonic()
    with pytest.raises(BusError, match=nowhere) as raised:
        ZenohBus(Connection(connect=(nowhere,), timeout=0.3))
    assert ".rs" not in str(raised.value)
    assert time.monotonic() - begin < 3.0


def test_a_taken_endpoint_is_told_from_other_failures(endpoint: str) -> None:
    with pytest.raises(EndpointTakenError, match=endpoint):
        ZenohBus(Connection("router", listen=(endpoint,)))


def test_closing_twice_is_allowed(connect: Connect) -> None:
    bus = connect()
    bus.close()
    bus.close()


class Node:
    """Ends after a number of events; notes when it was woken."""

    def __init__(self, events: int, deadline: float = inf) -> None:
        self.left, self.deadline, self.woken = events, deadline, 0

    @property
    def finished(self) -> bool:
        return self.left == 0

    def handle(self, event: Event) -> None:
        assert isinstance(event, Presence)
        self.left -= 1

    def wake(self, now: float) -> None:
        assert now >= self.deadline
        self.woken += 1
        self.deadline = inf


def test_driving_ends_with_the_node(connect: Connect) -> None:
    class Announced(Node):
        def wake(self, now: float) -> None:
            super().wake(now)
            other.announce(ALIVE)

    bus, other = connect(), connect()
    bus.watch(ALIVE)
    node = Announced(1, deadline=time.monotonic())
    drive(node, bus)
    assert (node.left, node.woken) == (0, 1)
    assert bus._session.is_closed()


def test_a_signal_ends_driving_after_last_words(connect: Connect) -> None:
    class Interrupted(Node):
        def wake(self, now: float) -> None:
            super().wake(now)
            threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()

    bus, words = connect(), []
    with pytest.raises(Stop):
        drive(Interrupted(1, deadline=0.0), bus, on_stop=lambda: words.append(bus._session.is_closed()))
    assert words == [False]
    assert bus._session.is_closed()


def test_only_the_first_signal_stops() -> None:
    cleaned = []

    @stop_on_signal()
    @stop_on_signal()
    def work() -> None:
        try:
            os.kill(os.getpid(), signal.SIGTERM)
        finally:
            os.kill(os.getpid(), signal.SIGTERM)
            cleaned.append("up")

    with pytest.raises(Stop):
        work()
    assert cleaned == ["up"]
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_a_peer_cannot_do_without_its_first_endpoint() -> None:
    connection = Connection("peer", connect=("tcp/a:1", "tcp/b:2"))
    assert configuration(connection)["connect"]["endpoints"] == ["tcp/a:1#exit_on_failure=true", "tcp/b:2"]


@pytest.mark.parametrize("mode", ["client", "router", "peer"])
def test_nobody_listens_or_searches_unasked(mode: str) -> None:
    config = configuration(Connection(mode))  # type: ignore[arg-type]  # one of the literals above
    assert config["listen"]["endpoints"] == []
    assert not config["scouting"]["multicast"]["enabled"]
    assert not config["scouting"]["gossip"]["enabled"]
    assert config["mode"] == mode
