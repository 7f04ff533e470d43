"""The router's process: which port it takes, and what it says when it cannot."""

import os

import pytest

from deploy.processes.router import listening, reserved
from protocol.bus.connection import Connection
from protocol.errors import EndpointTakenError

pytestmark = [pytest.mark.usefixtures("interruptible"), pytest.mark.timeout(60)]


def test_a_port_that_was_asked_for_and_is_taken_names_its_holder(endpoint: str) -> None:
    with pytest.raises(EndpointTakenError, match=rf"{endpoint}: .*process {os.getpid()}\)"):
        listening(Connection("router", listen=(endpoint,)))


def test_a_port_that_cannot_be_reached_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("deploy.processes.router.HOST", "127.255.255.255")  # as if the loopback were down
    with pytest.raises(EndpointTakenError, match=r"the last: .*Permission denied"):
        listening(Connection("router"))


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
