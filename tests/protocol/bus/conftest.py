"""Clients of a router in this process."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing

import pytest

from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus

Connect = Callable[..., ZenohBus]


@pytest.fixture
def connect(endpoint: str) -> Iterator[Connect]:
    with ExitStack() as stack:
        connection = Connection(connect=(endpoint,))
        yield lambda **how: stack.enter_context(closing(ZenohBus(connection, **how)))
