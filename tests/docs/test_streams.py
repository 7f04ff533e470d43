"""docs/streams.md: current, and true for a program that shares no code with this project."""

import ast
import re
import selectors
import subprocess
import sys
import time
from pathlib import Path

import msgpack
import pytest

from docs.reference.streams import PAGE, page
from protocol.bus.connection import Connection
from protocol.bus.zenoh import ZenohBus
from protocol.keys import STREAMS
from tests.campaigns.fuzz.messages import traffic


def test_page_is_current():
    assert PAGE.read_text() == page(), "run `python -m docs.reference.streams`"


@pytest.mark.process
def test_a_stock_subscriber_reads_every_stream(tmp_path: Path, endpoint: str):
    """The program on the page, as it stands there, against real zenoh."""
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    program = tmp_path / "subscriber.py"
    program.write_text(code[1])
    payloads = dict(samples[-1] for samples in traffic().values())
    publisher = ZenohBus(Connection(connect=(endpoint,)))
    reader = subprocess.Popen([sys.executable, program, endpoint, "local"], stdout=subprocess.PIPE, text=True)
    try:
        heard = _converse(publisher, reader, payloads)
    finally:
        reader.kill()
        reader.wait()
        reader.stdout.close()
        publisher.close()
    assert heard == {key: msgpack.unpackb(payload) for key, payload in payloads.items()}


def _converse(bus: ZenohBus, reader: subprocess.Popen, payloads: dict[str, bytes]) -> dict[str, list]:
    """Publish until the reader has printed something of every key."""
    publishers = {key: bus.publisher(STREAMS[key.rpartition("/")[2]], key) for key in payloads}
    heard: dict[str, list] = {}
    deadline = time.monotonic() + 60.0
    with selectors.DefaultSelector() as selector:
        selector.register(reader.stdout, selectors.EVENT_READ)
        while len(heard) < len(payloads) and time.monotonic() < deadline:
            for key, payload in payloads.items():
                publishers[key](payload)
            while selector.select(0.05) and len(heard) < len(payloads):
                key, kind, fields = reader.stdout.readline().split(" ", 2)
                heard[key] = [kind, *ast.literal_eval(fields)]
    return heard
