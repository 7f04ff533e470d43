"""The router's process: which port it takes, and what it says when it cannot."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import closing

import pytest

from deploy.library.load import load
from deploy.processes.router import listening, main, reserved
from deploy.processes.spawn import Process
from deploy.processes.supervisor import Supervisor
from deploy.processes.table import router
from deploy.run.fleet import Fleet
from deploy.run.options import RunOptions
from protocol.bus.bus import Presence
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.errors import EndpointTakenError, ProcessError
from protocol.keys import TOKEN, parse
from protocol.messages import Clock
from protocol.process.signals import STOP
from protocol.streams import QUESTIONS, STREAMS
from tests.deploy.processes import children

pytestmark = pytest.mark.timeout(60)


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """Ctrl-C ends a router that runs in this process."""
    with STOP.listening():
        yield


@pytest.mark.process
def test_routers_that_start_at_once_take_different_ports() -> None:
    names = [f"router-{n}" for n in range(4)]
    with Supervisor(children.spawner()) as supervisor:
        row = router(Connection("router"))
        supervisor.start(Process(name, row.entry, row.arguments, reports=True) for name in names)
        endpoints = {supervisor.report(name, 30.0) for name in names}
        assert len(endpoints) == len(names)
        for endpoint in endpoints:
            ZenohBus(Connection(connect=(endpoint,))).close()
        supervisor.stop()
        assert {usage.exit_code for usage in supervisor.usage()} == {0}


def test_a_port_that_was_asked_for_and_is_taken_names_its_holder() -> None:
    bus, endpoint = listening(Connection("router"))
    with closing(bus), pytest.raises(EndpointTakenError, match=rf"{endpoint}: .*process {os.getpid()}\)"):
        listening(Connection("router", listen=(endpoint,)))


@pytest.mark.process
def test_a_router_without_its_port_ends_at_once() -> None:
    bus, endpoint = listening(Connection("router"))
    with closing(bus), Supervisor(children.spawner()) as supervisor:
        supervisor.start([router(Connection("router", listen=(endpoint,)))])
        with pytest.raises(ProcessError, match="router could not start"):
            supervisor.report("router", 30.0)
        (exit_,) = supervisor.poll()
        assert not exit_.expected
        assert exit_.process.vital


@pytest.mark.process
def test_the_admin_space_shows_the_streams_as_they_are_declared() -> None:
    bus, endpoint = listening(Connection("router", admin=True))
    scenario = load("swap-2", ["control.speed=0.02"])
    kinds: dict[str, set[str]] = {}

    def look(clock: Clock) -> None:
        if clock.tick > 2 and not kinds:
            with closing(ZenohBus(Connection(connect=(endpoint,)))) as asking:
                for kind in ("subscriber", "publisher", "queryable", "token"):
                    head = f"/router/{kind}/"
                    replies = asking._session.get(f"@/*{head}disknav/shown/**", timeout=5.0)
                    kinds[kind] = {str(each.ok.key_expr).partition(head)[2] for each in replies if each.ok}

    with closing(bus), Fleet(scenario, RunOptions(router=endpoint, run="shown"), watch=look) as fleet:
        report = fleet.execute()
    assert report["verdict"] == "arrived"
    streams = {parse(key.replace("*", "1")).stream for key in kinds["publisher"]}
    assert (
        {name for name, each in STREAMS.items() if each.reliable and name != "result"}
        <= streams
        <= set(STREAMS)
    )
    assert {parse(key.replace("*", "1")).stream for key in kinds["queryable"]} == {
        each.name for each in QUESTIONS
    }
    tokens = [parse(key) for key in kinds["token"]]
    assert sorted((each.robot or 0, each.stream) for each in tokens) == [(n, TOKEN) for n in range(3)]
    heard = {parse(key.replace("*", "1")).stream for key in kinds["subscriber"]}
    assert {"tick", "state", "command", "clock"} <= heard <= set(STREAMS)


def test_nobody_else_takes_the_port_of_a_router_that_will_be_back() -> None:
    bus, endpoint = listening(Connection("router"))
    with reserved(endpoint):
        bus.close()
        other, elsewhere = listening(Connection("router"))
        other.close()
        assert elsewhere != endpoint
        back, again = listening(Connection("router", listen=(endpoint,)))
        back.close()
        assert again == endpoint


def test_a_signal_ends_the_router_which_worked_till_then() -> None:
    def ready(endpoint: str) -> None:
        with closing(ZenohBus(Connection(connect=(endpoint,)))) as one:
            one.announce("disknav/t/world/alive/1")
            with closing(ZenohBus(Connection(connect=(endpoint,)))) as other:
                other.watch("disknav/t/world/alive/1")
                assert other.receive(10.0) == Presence("disknav/t/world/alive/1", True)
        signal.raise_signal(signal.SIGINT)

    assert main(Connection("router"), ready=ready) == 0
