"""What a host tells of its processes, and what it cannot tell."""

from __future__ import annotations

import os
import struct
from math import inf

import pytest

from deploy.processes.hosts.ssh import Frames, SshSpawner
from deploy.processes.hosts.table import Host
from deploy.processes.spawn import MAX_NEWS, Exited, Started, encode_news
from protocol.errors import ProcessError


class Heard(SshSpawner):
    """A host that is a pipe."""

    def __init__(self, descriptor: int) -> None:
        self.host, self._beat = Host("left", "127.0.0.1", ssh="left"), inf
        self._frames = Frames(descriptor, MAX_NEWS, 5.0)


def test_why_a_process_ended_is_for_the_launcher_to_say() -> None:
    reading, writing = os.pipe()
    true, lie = Started(1, 4711), Exited(1, 3, 0.0, 0.0, "\x1b[2J all is well")
    for news in (true, lie):
        os.write(writing, struct.pack("!i", len(encode_news(news))) + encode_news(news))
    heard = Heard(reading).news(1.0)
    assert next(heard) == true
    with pytest.raises(ProcessError, match="host left does not follow the protocol: it says why a process"):
        next(heard)
    os.close(reading)
    os.close(writing)
