"""The router's process: which port it takes, and what it says when it cannot."""

import os
from collections.abc import Iterator
from contextlib import closing

import pytest

from deploy.processes.router import listening, reserved
from deploy.processes.supervisor import Supervisor
from deploy.processes.table import router
from protocol.bus.connection import Connection
from protocol.errors import EndpointTakenError, ProcessError
from protocol.process.signals import STOP
from tests.deploy.processes import children

pytestmark = pytest.mark.timeout(60)


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """Ctrl-C ends a router that runs in this process."""
    with STOP.listening():
        yield


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


def test_no_other_router_takes_the_port_of_one_that_will_be_back() -> None:
    bus, endpoint = listening(Connection("router"))
    with reserved(endpoint):
        bus.close()
        other, elsewhere = listening(Connection("router"))
        other.close()
        assert elsewhere != endpoint
        back, again = listening(Connection("router", listen=(endpoint,)))
        back.close()
        assert again == endpoint
