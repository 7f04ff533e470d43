"""The zenoh bus on real sessions: through a router, and between peers."""

import socket
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, nullcontext
from pathlib import Path
from unittest.mock import Mock

import pytest

from deploy.processes.supervisor import Supervisor
from protocol.bus.bus import Event, Presence, Query, Sample
from protocol.bus.connection import Connection, configuration
from protocol.bus.zenoh import ZenohBus
from protocol.errors import BusError, UnservedError
from protocol.keys import STREAMS
from tests.deploy.processes import children
from tests.until import until

pytestmark = pytest.mark.timeout(30)

STATE, ALIVE = "disknav/t/robot/1/state", "disknav/t/robot/1/alive"
SCENARIO = "disknav/t/world/scenario"
PATIENCE = 10.0
Connect = Callable[..., ZenohBus]


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
    assert second.ask(SCENARIO, b"may I?", PATIENCE) == [b"yes"]
    answering.join()
    publish(b"here")  # the answer came after the subscription: before, no subscriber might be known
    sample = first.receive(PATIENCE)
    assert isinstance(sample, Sample)
    assert (sample.key, sample.payload) == (STATE, b"here")
    second.close()
    assert first.receive(PATIENCE) == Presence(ALIVE, False)


def answer(bus: ZenohBus, reply: bytes) -> None:
    request = bus.receive(PATIENCE)
    assert isinstance(request, Query)
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
    heard = until(lambda: publish(b"1") or listener.receive(0.1))  # the publisher knows a subscriber
    assert (heard.key, heard.payload) == (STATE, b"1")
    assert speaker.receive(0.05) is None


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
        assert time.monotonic() - begin < 8.0  # an unnoticed death would take 10 s


def test_asking_waits_for_one_that_will_serve(connect: Connect) -> None:
    asker, server, heir = connect(), connect(), connect()
    with ThreadPoolExecutor() as pool:
        asking = pool.submit(asker.ask, SCENARIO, b"may I?", PATIENCE, once=True)
        assert server.receive(0.1) is None  # nobody serves it
        server.serve(SCENARIO)
        answer(server, b"now")
        assert asking.result() == [b"now"]
        asking = pool.submit(asker.ask, SCENARIO, b"may I?", PATIENCE, once=True)
        assert isinstance(server.receive(PATIENCE), Query)
        heir.serve(SCENARIO)
        server.close()  # perhaps after it has obeyed
        assert heir.receive(0.3) is None
        assert isinstance(asking.exception(PATIENCE), BusError)


def test_only_an_order_relies_on_news_of_who_serves_its_key(connect: Connect) -> None:
    asker, server = connect(), connect()
    server.serve(SCENARIO)
    no_news = nullcontext(Mock(matching_status=Mock(matching=False)))
    asker._session = Mock(wraps=asker._session, declare_querier=lambda _: no_news)
    for payload, once in ((b"an order", True), (b"may I?", False)):
        with pytest.raises(BusError, match=r"within 0\.2 s"):
            asker.ask(SCENARIO, payload, 0.2, once=once)
    answer(server, b"too late")  # to the question: the order was not sent


@pytest.mark.parametrize("served", [False, True])
def test_an_unanswered_request_ends_in_time_and_says_if_it_was_served(connect: Connect, served: bool) -> None:
    if served:
        connect().serve(SCENARIO)  # by a process that never receives
    begin = time.monotonic()
    with pytest.raises(BusError, match=SCENARIO) as raised:
        connect().ask(SCENARIO, b"may I?", 2.0 if served else 0.2)
    assert time.monotonic() - begin < 8.0  # zenoh by itself would wait for 10 s
    assert isinstance(raised.value, UnservedError) is not served


@pytest.mark.parametrize("mode", ["client", "router", "peer"])
def test_no_session_listens_or_searches_unasked(mode: str) -> None:
    config = configuration(Connection(mode))  # type: ignore[arg-type]  # one of the literals above
    assert config["listen"]["endpoints"] == []
    assert not config["scouting"]["multicast"]["enabled"]
    assert not config["scouting"]["gossip"]["enabled"]
    assert config["mode"] == mode


# -- others that do not do their part: no wait is without end, and no queue


def test_receiving_is_bounded(connect: Connect) -> None:
    bus, begin = connect(), time.monotonic()
    assert bus.receive(0.0) is bus.receive(0.05) is None
    assert 0.05 <= time.monotonic() - begin < PATIENCE


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
    until(lambda: listener._queue.qsize() >= 21)  # and that its token is gone
    heard = 0
    while heard + listener.dropped < 21:
        assert listener.receive(PATIENCE) is not None
        heard += 1
    assert heard + listener.dropped == 21
    assert listener.dropped > 0


def test_an_unreachable_router_is_named() -> None:
    nowhere = "tcp/127.0.0.1:9"
    begin = time.monotonic()
    with pytest.raises(BusError, match=nowhere) as raised:
        ZenohBus(Connection(connect=(nowhere,), timeout=0.3))
    assert ".rs" not in str(raised.value)
    assert time.monotonic() - begin < PATIENCE
