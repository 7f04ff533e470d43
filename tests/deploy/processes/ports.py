"""Ports that stay free until a test's process takes them, and again when it is started anew."""

import os
import re
import socket
from collections.abc import Iterator
from itertools import count

_FIRST, _EACH = 20_000, 1_500  # below the ephemeral ports of the system; some for each worker


def _candidates() -> Iterator[int]:
    worker = int("".join(re.findall(r"\d+", os.environ.get("PYTEST_XDIST_WORKER", "0")))) % 8
    begin = os.getpid() % _EACH  # another place than the run before, whose last connections may linger
    return (_FIRST + worker * _EACH + (begin + number) % _EACH for number in count())


_CANDIDATES = _candidates()


def free_ports(number: int) -> list[int]:
    """Free ports of 127.0.0.1, which the system assigns to no process that does not ask for them."""
    found: list[int] = []
    while len(found) < number:
        port = next(_CANDIDATES)
        try:
            socket.create_server(("127.0.0.1", port)).close()
        except OSError:
            continue
        found.append(port)
    return found
